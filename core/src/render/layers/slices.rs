//! The plate cut into slices: which rungs have light where, and what the inner renderer is given.
//!
//! A pixel between two rungs gives each the share that is linear in vergence, so that a tilted surface
//! has no bands.

use super::hidden::HiddenRow;
use super::ladder::Ladder;
use super::resolve::Crop;
use crate::field::ImagePoint;
use crate::psf::Reach;
use crate::render::{Displacement, Plane, PlateMap, Scene};
use rayon::prelude::*;

/// Crops begin and end on multiples of this from the frame's corner, px, so that inner renderers that
/// work tile by tile have their tiles where they would have them on the whole plate.
const ALIGNED_PX: i64 = 128;
/// Room about the light beyond what kernels at a few places need: kernels between may be larger.
const SPARE_SHARE: f64 = 0.1;
const SPARE_PX: f64 = 4.0;

/// What is to be cut: the visible samples and those hidden behind them.
pub(super) struct Stock<'a> {
    pub(super) planes: &'a [Plane<'a>],
    /// Place of every pixel on the ladder.
    pub(super) places: &'a [f32],
    /// Samples besides, hidden ones and corrections of those at edges.
    pub(super) further: &'a [&'a [HiddenRow]],
    pub(super) width: usize,
}

/// Columns and rows that hold light, ends not included.
type Box4 = [usize; 4];

const NOTHING: Box4 = [usize::MAX, usize::MAX, 0, 0];

fn joined(a: Box4, b: Box4) -> Box4 {
    [
        a[0].min(b[0]),
        a[1].min(b[1]),
        a[2].max(b[2]),
        a[3].max(b[3]),
    ]
}

impl Stock<'_> {
    /// The smallest part of the plate that holds all light of each rung; `None` where there is none.
    pub(super) fn extents(&self, ladder: &Ladder) -> Vec<Option<Crop>> {
        let row_extents = |row: usize| {
            let mut boxes = vec![NOTHING; ladder.len()];
            let mut add = |place: f32, column: usize| {
                let (low, high) = ladder.about(place);
                for rung in [low, high] {
                    if share(place, ladder.place_of(rung)) > 0.0 {
                        boxes[rung] = joined(boxes[rung], [column, row, column + 1, row + 1]);
                    }
                }
            };
            for (column, place) in self.row(row).iter().enumerate() {
                add(*place, column);
            }
            for further in self.further {
                let HiddenRow {
                    columns, places, ..
                } = &further[row];
                for (column, place) in columns.iter().zip(places) {
                    add(*place, *column as usize);
                }
            }
            boxes
        };
        let rows = self.places.len() / self.width;
        let all = (0..rows).into_par_iter().map(row_extents).reduce(
            || vec![NOTHING; ladder.len()],
            |a, b| a.into_iter().zip(b).map(|(a, b)| joined(a, b)).collect(),
        );
        let crop = |[left, top, right, bottom]: Box4| {
            (left < right).then(|| Crop {
                column: left,
                row: top,
                width: right - left,
                height: bottom - top,
            })
        };
        all.into_iter().map(crop).collect()
    }

    fn row(&self, row: usize) -> &[f32] {
        &self.places[row * self.width..(row + 1) * self.width]
    }

    /// The planes and the presence of the slice at `place` on the ladder, within `crop`.
    pub(super) fn slice(&self, place: f32, crop: Crop) -> (Vec<Vec<f32>>, Vec<f32>) {
        let size = crop.width * crop.height;
        let mut presence = vec![0.0; size];
        let lines = presence.par_chunks_mut(crop.width).enumerate();
        lines.for_each(|(line, out)| {
            let row = &self.row(crop.row + line)[crop.column..];
            for (out, own) in out.iter_mut().zip(row) {
                *out = share(*own, place);
            }
        });
        let mut planes: Vec<_> = (0..self.planes.len()).map(|_| vec![0.0; size]).collect();
        for (plane, out) in self.planes.iter().zip(&mut planes) {
            let lines = out.par_chunks_mut(crop.width).enumerate();
            lines.for_each(|(line, out)| {
                let from = (crop.row + line) * self.width + crop.column;
                let shares = &presence[line * crop.width..];
                for ((out, sample), share) in out.iter_mut().zip(&plane.samples[from..]).zip(shares)
                {
                    *out = sample * share;
                }
            });
        }
        for further in self.further {
            let rows = &further[crop.row..crop.row + crop.height];
            add(rows, place, crop, &mut planes, &mut presence);
        }
        (planes, presence)
    }
}

/// Adds the samples of `rows` that the slice at `place` has to it.
fn add(rows: &[HiddenRow], place: f32, crop: Crop, planes: &mut [Vec<f32>], presence: &mut [f32]) {
    for (line, row) in rows.iter().enumerate() {
        let samples = row.samples.chunks_exact(planes.len());
        let all = row.columns.iter().zip(&row.places);
        for (((column, own), weight), samples) in all.zip(&row.weights).zip(samples) {
            let share = share(*own, place);
            // Light lies within the crop, and with it every sample that has a share.
            if share > 0.0 {
                let index = line * crop.width + *column as usize - crop.column;
                presence[index] += share * weight;
                for (plane, sample) in planes.iter_mut().zip(samples) {
                    plane[index] += share * sample;
                }
            }
        }
    }
}

/// How much of a sample at `own` place belongs to the slice at `place`.
fn share(own: f32, place: f32) -> f32 {
    (1.0 - (own - place).abs()).max(0.0)
}

/// `light`'s extent and as much about it as its kernels at `vergence` reach.
pub(super) fn with_reach(scene: &Scene, light: Crop, vergence: f64) -> Crop {
    let reach = reach(scene, light, vergence);
    let offset = [scene.map.origin.x_px, scene.map.origin.y_px]
        .map(|origin| (origin * scene.map.scale).round() as i64);
    let span = |first: usize, size: usize, before: f64, after: f64, offset: i64, plate: usize| {
        let low = (first as i64 - before.ceil() as i64 + offset).div_euclid(ALIGNED_PX);
        let end = (first + size) as i64 + after.ceil() as i64 + offset;
        let high = (end + ALIGNED_PX - 1).div_euclid(ALIGNED_PX);
        let low = (low * ALIGNED_PX - offset).clamp(0, plate as i64);
        let high = (high * ALIGNED_PX - offset).clamp(0, plate as i64);
        (low as usize, (high - low) as usize)
    };
    let (x, y) = (
        span(
            light.column,
            light.width,
            reach.left_px,
            reach.right_px,
            offset[0],
            scene.width,
        ),
        span(
            light.row,
            light.height,
            reach.up_px,
            reach.down_px,
            offset[1],
            scene.height,
        ),
    );
    Crop {
        column: x.0,
        row: y.0,
        width: x.1,
        height: y.1,
    }
}

/// How far kernels of sources within `light` reach, probed at nine places.
fn reach(scene: &Scene, light: Crop, vergence: f64) -> Reach {
    let mut far = [0.0_f64; 4];
    let scale = scene.map.scale;
    for (x, y) in (0..9).map(|k| (k % 3, k / 3)) {
        let column = light.column + (light.width - 1) * x / 2;
        let row = light.row + (light.height - 1) * y / 2;
        let at = scene
            .lens
            .frame()
            .field_point(scene.map.frame_point(column, row));
        for channel in 0..scene.lens.channel_count() {
            let placed = scene.lens.blur_at(channel, at, vergence);
            let reach = scene.model.reach_px(&placed.blur.rescaled(scale));
            // Towards the mean of channels or not: twice the whole displacement bounds both.
            let shift = match scene.displacement {
                Displacement::None => 0.0,
                _ => 2.0 * scale * placed.displacement_px.0.hypot(placed.displacement_px.1),
            };
            let sides = [reach.left_px, reach.right_px, reach.up_px, reach.down_px];
            for (far, side) in far.iter_mut().zip(sides) {
                *far = far.max(side + shift);
            }
        }
    }
    // Not a number, or larger than any plate: the inner renderer says what is wrong.
    let [left_px, right_px, up_px, down_px] = far.map(|far| {
        let roomy = far * (1.0 + SPARE_SHARE) + SPARE_PX;
        if roomy < 1e6 { roomy } else { 1e6 }
    });
    Reach {
        left_px,
        right_px,
        up_px,
        down_px,
    }
}

/// The scene of a slice: `crop` of the plate, all at one vergence.
pub(super) fn cropped<'a>(scene: &Scene<'a>, crop: Crop, vergence: f64) -> Scene<'a> {
    let PlateMap { origin, scale } = scene.map;
    let map = PlateMap {
        origin: ImagePoint::new(
            origin.x_px + crop.column as f64 / scale,
            origin.y_px + crop.row as f64 / scale,
        ),
        scale,
    };
    Scene {
        width: crop.width,
        height: crop.height,
        map,
        vergence: crate::render::VergencePass::Constant(vergence),
        ..*scene
    }
}
