//! The range of depth about each pixel of a plate.

use rayon::prelude::*;

/// The layer coordinates of the farthest and the nearest of the nine pixels about each pixel of a plate.
///
/// It tells without a look at the nine pixels that none of them lies in a layer, which holds for most.
#[derive(Default)]
pub(super) struct NearbyRange {
    /// Row-major.
    ranges: Vec<[f32; 2]>,
}

impl NearbyRange {
    /// Finds the ranges of a plate from the layer coordinates of its pixels, in rows of `width`. Pixels beyond its edges are those at
    /// the edge.
    pub(super) fn new(coordinates: &[f32], width: usize) -> Self {
        let last = (coordinates.len() / width.max(1)).saturating_sub(1);
        let mut ranges = vec![[0.0; 2]; coordinates.len()];
        let lines = ranges.par_chunks_mut(width.max(1)).enumerate();
        lines.for_each_init(
            || vec![[0.0; 2]; width],
            |columns, (row, out)| {
                let line = |row: usize| &coordinates[row * width..][..width];
                let (above, own, below) = (
                    line(row.saturating_sub(1)),
                    line(row),
                    line((row + 1).min(last)),
                );
                for (column, range) in columns.iter_mut().enumerate() {
                    let (a, b, c) = (above[column], own[column], below[column]);
                    *range = [a.min(b).min(c), a.max(b).max(c)];
                }
                for (column, range) in out.iter_mut().enumerate() {
                    let [before, after] =
                        [column.saturating_sub(1), (column + 1).min(width - 1)].map(|k| columns[k]);
                    let own = columns[column];
                    *range = [
                        before[0].min(own[0]).min(after[0]),
                        before[1].max(own[1]).max(after[1]),
                    ];
                }
            },
        );
        Self { ranges }
    }

    /// Returns whether any of the pixels about pixel `index` may belong to the layer at coordinate `layer`.
    pub(super) fn may_hold(&self, index: usize, layer: f32) -> bool {
        let [farthest, nearest] = self.ranges[index];
        farthest < layer + 1.0 && nearest > layer - 1.0
    }
}
