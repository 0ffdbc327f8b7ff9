//! Measured tiles made ready for comparison: unit sum, laid in squares of one size.

use crate::measure::MeasuredTile;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::moments::CentralMoments;
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::moments::support::{self, Support};
use seidel_optics::observations::ObservationSet;
use seidel_optics::psf::SampleGrid;

/// Empty pixels on each side of the largest tile of a group without noise, so that what a model draws
/// beyond the tile counts against it. Where noise masks the tiles nothing is known beyond their
/// edges, and there is no margin.
pub(crate) const MARGIN_PX: usize = 8;

/// One tile on the square of its group.
pub(crate) struct PlacedTile {
    /// Place in the field of the lens.
    pub(crate) field: FieldPoint,
    /// Measured central moments, the pixel's area included: those that a kernel sampled at pixel
    /// centres must have.
    pub(crate) plain: CentralMoments,
    /// Measured centroid, px from the top-left corner of the square.
    pub(crate) centroid: (f64, f64),
    /// The tile, zero outside its support, unit sum, row-major on the square.
    pub(crate) truth: Vec<f64>,
}

impl PlacedTile {
    /// Centroid from the centre of a square of `side` px.
    pub(crate) fn off_centre(&self, side: usize) -> (f64, f64) {
        let middle = side as f64 / 2.0;
        (self.centroid.0 - middle, self.centroid.1 - middle)
    }

    /// The square as a grid about the centroid.
    pub(crate) fn window(&self, side: usize) -> SampleGrid {
        SampleGrid::for_tile(side, side, self.centroid.0, self.centroid.1)
    }
}

/// Lays the tiles of one channel at one distance, of any of `sets`, in squares as large as the largest of them and, if
/// none is masked, [`MARGIN_PX`] more on each side. Returns the squares' side in px.
pub(crate) fn place(
    sets: &[ObservationSet],
    tiles: &[&MeasuredTile],
    frame: &Frame,
    support: Support,
) -> (usize, Vec<PlacedTile>) {
    let mut largest = 0;
    let mut masks = Vec::with_capacity(tiles.len());
    for measured in tiles {
        let observation = &sets[measured.set].observations[measured.observation];
        let tile = &observation.tiles[measured.channel];
        largest = largest.max(tile.width()).max(tile.height());
        masks.push(support::mask(
            &observation.light(measured.channel),
            observation.noise_sigma[measured.channel],
            support,
        ));
    }
    let margin = if masks.iter().any(Option::is_some) {
        0
    } else {
        MARGIN_PX
    };
    let side = largest + 2 * margin;
    let placed = tiles
        .iter()
        .zip(masks)
        .map(|(measured, mask)| {
            place_one(&sets[measured.set], measured, frame, mask.as_deref(), side)
        })
        .collect();
    (side, placed)
}

fn place_one(
    set: &ObservationSet,
    measured: &MeasuredTile,
    frame: &Frame,
    mask: Option<&[bool]>,
    side: usize,
) -> PlacedTile {
    let observation = &set.observations[measured.observation];
    let light = observation.light(measured.channel);
    let (width, height) = (light.width(), light.height());
    let (left, top) = ((side - width) / 2, (side - height) / 2);
    let mut truth = vec![0.0; side * side];
    for (index, &sample) in light.samples().iter().enumerate() {
        if mask.is_none_or(|m| m[index]) {
            truth[(top + index / width) * side + left + index % width] = f64::from(sample);
        }
    }
    to_unit_sum(&mut truth);
    let (x, y) = observation.tile_point(measured.centroid);
    PlacedTile {
        field: measured.field_point(frame),
        plain: measured.optical.with_added_variance(PIXEL_VARIANCE_PX2),
        centroid: (left as f64 + x, top as f64 + y),
        truth,
    }
}

/// Scales `kernel` to unit sum; left as it is if its sum is zero.
pub(crate) fn to_unit_sum(kernel: &mut [f64]) {
    let sum: f64 = kernel.iter().sum();
    if sum != 0.0 {
        kernel.iter_mut().for_each(|v| *v /= sum);
    }
}
