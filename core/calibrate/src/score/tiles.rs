//! Measured tiles prepared for comparison: unit sum, on squares of one size.

use std::borrow::Cow;

use super::BlurScorer;
use super::mosaic_gaps::MosaicGaps;
use crate::measure::MeasuredTile;
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::moments::CentralMoments;
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::moments::support::{Support, TilePixels};
use seidel_optics::observations::ObservationSet;

/// Zero margin on each side of the largest tile of a group without noise, px. It penalises predictions beyond
/// the tile. Masked tiles get no margin, because nothing is known beyond their support.
pub(crate) const MARGIN_PX: usize = 8;

/// A measured tile on the square of its group.
pub(crate) struct PreparedTile {
    /// Field position.
    pub(crate) field: FieldPoint,
    /// Measured central moments with pixel integration, as kernels sampled at pixel centres have them.
    pub(crate) moments: CentralMoments,
    /// Measured centroid, px from the top-left corner of the square.
    pub(crate) centroid: (f64, f64),
    /// Light of the tile, in its units: the sum that [`PreparedTile::measured`] was divided by.
    pub(crate) total: f64,
    /// Samples of unit sum, zero outside the support, row-major on the square.
    pub(crate) measured: Vec<f64>,
    /// Whether the PSF is too narrow for its pixels to tell its centroid.
    pub(crate) centroid_unknown: bool,
    /// Expected squared norm of the noise in `measured`; zero where the noise is unknown.
    pub(crate) noise_power: f64,
    /// Pixels of other colours, if the tile is of a mosaic. `measured` is filled in there.
    pub(crate) gaps: Option<MosaicGaps>,
}

impl PreparedTile {
    /// Returns the centroid relative to the centre of a square of `side` px.
    pub(crate) fn off_centre(&self, side: usize) -> (f64, f64) {
        let middle = side as f64 / 2.0;
        (self.centroid.0 - middle, self.centroid.1 - middle)
    }

    /// Returns the measured samples to compare with `kernel`: in a mosaic, completed by the kernel itself.
    pub(crate) fn compared_with(&self, kernel: &[f64]) -> Cow<'_, [f64]> {
        match &self.gaps {
            None => Cow::Borrowed(&self.measured),
            Some(gaps) => Cow::Owned(gaps.completed(&self.measured, kernel)),
        }
    }

    /// Returns the indices of the measured pixels.
    pub(crate) fn counted(&self) -> Cow<'_, [usize]> {
        match &self.gaps {
            None => Cow::Owned((0..self.measured.len()).collect()),
            Some(gaps) => Cow::Borrowed(gaps.counted()),
        }
    }

    /// Returns the forward-blur SNR of `kernel`, dB; `power` is V(P) of the measured samples.
    pub(crate) fn snr_db(&self, scorer: &BlurScorer, power: f64, kernel: &[f64]) -> f64 {
        let compared = self.compared_with(kernel);
        let power = match &self.gaps {
            None => power,
            Some(_) => scorer.blurred_power(&compared),
        };
        scorer.snr_db(&compared, power, kernel)
    }
}

/// Prepares the tiles of one channel at one distance. Returns the side of the squares in px, and the tiles.
///
/// Squares are as large as the largest tile; if no tile is masked they have a margin of [`MARGIN_PX`] on each
/// side.
pub(crate) fn prepare_tiles(
    sets: &[ObservationSet],
    tiles: &[&MeasuredTile],
    frame: &Frame,
    support: Support,
) -> (usize, Vec<PreparedTile>) {
    let mut largest = 0;
    let mut masks = Vec::with_capacity(tiles.len());
    for measured in tiles {
        let observation = &sets[measured.set].observations[measured.observation];
        let tile = &observation.tiles[measured.channel];
        largest = largest.max(tile.width()).max(tile.height());
        let counted = sets[measured.set].counted(observation, measured.channel);
        let pixels = TilePixels {
            tile: &observation.light(measured.channel),
            counted: counted.as_deref(),
            noise_sigma: observation.noise_sigma[measured.channel],
        };
        masks.push(pixels.mask(support));
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
            prepare_tile(&sets[measured.set], measured, frame, mask.as_deref(), side)
        })
        .collect();
    (side, placed)
}

fn prepare_tile(
    set: &ObservationSet,
    measured: &MeasuredTile,
    frame: &Frame,
    mask: Option<&[bool]>,
    side: usize,
) -> PreparedTile {
    let observation = &set.observations[measured.observation];
    let light = observation.light(measured.channel);
    let (width, height) = (light.width(), light.height());
    let (left, top) = ((side - width) / 2, (side - height) / 2);
    let mut measured_kernel = vec![0.0; side * side];
    let mut counted_pixels = vec![false; side * side];
    let (mut sum, mut counted) = (0.0, 0);
    for (index, &sample) in light.samples().iter().enumerate() {
        if mask.is_none_or(|m| m[index]) {
            let pixel = (top + index / width) * side + left + index % width;
            measured_kernel[pixel] = f64::from(sample);
            counted_pixels[pixel] = true;
            sum += f64::from(sample);
            counted += 1;
        }
    }
    let sigma = observation.noise_sigma[measured.channel];
    let mut noise_power = match sigma {
        Some(sigma) if sum != 0.0 => f64::from(counted) * (sigma / sum).powi(2),
        _ => 0.0,
    };
    let gaps = measured
        .is_mosaic
        .then(|| MosaicGaps::new(&counted_pixels, side));
    if let Some(gaps) = &gaps {
        let (sigma, gain) = (sigma.unwrap_or(0.0), observation.gain.unwrap_or(0.0));
        let variance = |v: &f64| sigma * sigma + gain * v.max(0.0);
        let variances: Vec<f64> = measured_kernel.iter().map(variance).collect();
        gaps.fill(&mut measured_kernel);
        let sum: f64 = measured_kernel.iter().sum();
        noise_power = gaps.total_variance(&variances) / (sum * sum).max(f64::MIN_POSITIVE);
    }
    let total = measured_kernel.iter().sum();
    to_unit_sum(&mut measured_kernel);
    let (x, y) = observation.tile_point(measured.centroid);
    PreparedTile {
        field: measured.field_point(frame),
        moments: measured.optical.with_added_variance(PIXEL_VARIANCE_PX2),
        centroid: (left as f64 + x, top as f64 + y),
        total,
        measured: measured_kernel,
        centroid_unknown: measured.centroid_is_unknown(),
        noise_power,
        gaps,
    }
}

/// Scales `kernel` to unit sum, unless its sum is zero.
pub(crate) fn to_unit_sum(kernel: &mut [f64]) {
    let sum: f64 = kernel.iter().sum();
    if sum != 0.0 {
        kernel.iter_mut().for_each(|v| *v /= sum);
    }
}
