//! The range of depth in each block of a plate.

use super::super::layered_plate::LayeredPlate;
use rayon::prelude::*;
use std::ops::Range;

/// Side of the blocks whose range of depth is known, on a grid fixed to the frame, px.
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
    /// Pixels of the first block that lie outside the plate, along x and y.
    before: [usize; 2],
    columns: usize,
    rows: usize,
    /// Layer coordinates of the farthest and the nearest pixel, row-major.
    ranges: Vec<(f32, f32)>,
    /// Layer coordinate of the nearest pixel of the plate.
    nearest: f32,
}

impl SurfaceBlocks {
    pub(super) fn new(input: &LayeredPlate) -> Self {
        let before = input.origin.map(|at| at % BLOCK_PX);
        let columns = (input.width + before[0]).div_ceil(BLOCK_PX);
        let rows = (input.height + before[1]).div_ceil(BLOCK_PX);
        let band = |band: usize| {
            let first = |band: usize| {
                (band * BLOCK_PX)
                    .saturating_sub(before[1])
                    .min(input.height)
            };
            let lines = input.width * first(band)..input.width * first(band + 1);
            let mut ranges = vec![(f32::INFINITY, f32::NEG_INFINITY); columns];
            for line in input.coordinates[lines].chunks_exact(input.width) {
                for (column, at) in line.iter().enumerate() {
                    let range = &mut ranges[(column + before[0]) / BLOCK_PX];
                    *range = (range.0.min(*at), range.1.max(*at));
                }
            }
            ranges
        };
        let bands: Vec<_> = (0..rows).into_par_iter().map(band).collect();
        let ranges = bands.concat();
        let nearest = ranges.iter().map(|range| range.1);
        Self {
            before,
            columns,
            rows,
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
        // In the pixels of the first block.
        let middle = (
            middle.0 + self.before[0] as f64,
            middle.1 + self.before[1] as f64,
        );
        for row in blocks_within(middle.1, widest, self.rows) {
            for column in blocks_within(middle.0, widest, self.columns) {
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
        let mut found = vec![false; layers.len()];
        let [x, y] = self.before.map(|before| before as f64);
        for row in blocks_within(middle.1 + y, reach_px, self.rows) {
            for column in blocks_within(middle.0 + x, reach_px, self.columns) {
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
        let block = |at: i64, axis: usize, count: usize| {
            ((at.max(0) as usize + self.before[axis]) / BLOCK_PX).min(count - 1)
        };
        let [left, right] = columns.map(|at| block(at, 0, self.columns));
        let [top, bottom] = rows.map(|at| block(at, 1, self.rows));
        (top..=bottom).any(|row| {
            let row = &self.ranges[row * self.columns..];
            let mut ranges = row[left..=right].iter();
            ranges.any(|(low, high)| *low < layer + 1.0 && *high > layer - 1.0)
        })
    }
}

/// Returns those of `count` blocks that lie within `reach_px` of a position.
fn blocks_within(at: f64, reach_px: f64, count: usize) -> Range<usize> {
    let block = |at: f64| (at.max(0.0) as usize / BLOCK_PX).min(count - 1);
    block(at - reach_px)..block(at + reach_px) + 1
}
