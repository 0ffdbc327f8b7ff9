//! The range of depth in each block of a plate.

use super::super::layered_plate::LayeredPlate;
use rayon::prelude::*;

/// Side of the blocks whose range of depth is known, px.
const BLOCK_PX: usize = 16;

/// The surfaces nearer than a light that its rays pass.
pub(super) struct NearerSurfaces<'a> {
    /// Least layer coordinate.
    pub(super) from: f32,
    /// Distance from the light within which rays meet the surface at a layer coordinate, px.
    pub(super) reach_px: &'a dyn Fn(f32) -> f64,
}

/// The nearest and the farthest surface of each block of a plate.
#[derive(Default)]
pub(super) struct SurfaceBlocks {
    columns: usize,
    rows: usize,
    /// Layer coordinates of the farthest and the nearest pixel, row-major.
    ranges: Vec<(f32, f32)>,
    /// Layer coordinate of the nearest pixel of the plate.
    nearest: f32,
}

impl SurfaceBlocks {
    pub(super) fn new(input: &LayeredPlate) -> Self {
        let columns = input.width.div_ceil(BLOCK_PX);
        let bands = input.coordinates.par_chunks(input.width * BLOCK_PX);
        let band = |band: &[f32]| {
            let mut ranges = vec![(f32::INFINITY, f32::NEG_INFINITY); columns];
            for line in band.chunks_exact(input.width) {
                for (range, block) in ranges.iter_mut().zip(line.chunks(BLOCK_PX)) {
                    for at in block {
                        *range = (range.0.min(*at), range.1.max(*at));
                    }
                }
            }
            ranges
        };
        let bands: Vec<_> = bands.map(band).collect();
        let ranges = bands.concat();
        let nearest = ranges.iter().map(|range| range.1);
        Self {
            columns,
            rows: bands.len(),
            nearest: nearest.fold(f32::NEG_INFINITY, f32::max),
            ranges,
        }
    }

    /// Returns whether rays of a light at `middle` may meet any of the surfaces.
    pub(super) fn any_within(&self, middle: (f64, f64), nearer: &NearerSurfaces) -> bool {
        // A surface as blurred as the light, on the other side of focus, lies at twice the distance from the light.
        if self.nearest < nearer.from {
            return false;
        }
        let farthest = |at: f32| (nearer.reach_px)(at).max((nearer.reach_px)(nearer.from));
        let widest = farthest(self.nearest);
        let blocks = |at: f64, count: usize| {
            let block = |at: f64| (at.max(0.0) as usize / BLOCK_PX).min(count - 1);
            block(at - widest)..block(at + widest) + 1
        };
        for row in blocks(middle.1, self.rows) {
            for column in blocks(middle.0, self.columns) {
                let (_, high) = self.ranges[row * self.columns + column];
                if high < nearer.from {
                    continue;
                }
                // The nearest point of the block, seen from the light.
                let distance = |block: usize, at: f64| {
                    let first = (block * BLOCK_PX) as f64;
                    (first - at).max(at - first - BLOCK_PX as f64).max(0.0)
                };
                let apart = distance(column, middle.0).max(distance(row, middle.1));
                if apart <= farthest(high) {
                    return true;
                }
            }
        }
        false
    }

    /// Returns those of the `layers` that hold pixels within `reach_px` of a point.
    pub(super) fn layers_within(
        &self,
        middle: (f64, f64),
        reach_px: f64,
        layers: &[f32],
    ) -> impl Iterator<Item = f32> {
        let blocks = |at: f64, count: usize| {
            let block = |at: f64| (at.max(0.0) as usize / BLOCK_PX).min(count - 1);
            block(at - reach_px)..block(at + reach_px) + 1
        };
        let mut found = vec![false; layers.len()];
        for row in blocks(middle.1, self.rows) {
            for column in blocks(middle.0, self.columns) {
                let (low, high) = self.ranges[row * self.columns + column];
                for (found, at) in found.iter_mut().zip(layers) {
                    *found |= *at > low - 1.0 && *at < high + 1.0;
                }
            }
        }
        let pairs = layers.iter().zip(found);
        pairs.filter_map(|(at, found)| found.then_some(*at))
    }

    /// Returns whether the layer at coordinate `layer` may hold any of these `columns` and `rows` of pixels, ends included. Pixels beyond
    /// the plate are those at its edge.
    pub(super) fn may_hold(&self, columns: [i64; 2], rows: [i64; 2], layer: f32) -> bool {
        let block = |at: i64, count: usize| (at.max(0) as usize / BLOCK_PX).min(count - 1);
        let [left, right] = columns.map(|at| block(at, self.columns));
        let [top, bottom] = rows.map(|at| block(at, self.rows));
        (top..=bottom).any(|row| {
            let row = &self.ranges[row * self.columns..];
            let mut ranges = row[left..=right].iter();
            ranges.any(|(low, high)| *low < layer + 1.0 && *high > layer - 1.0)
        })
    }
}
