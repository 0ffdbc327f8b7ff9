//! The tiles of a pyramid level, and the nodes at their corners where the lens is evaluated.

use super::image::Size;
use crate::Scene;
use std::ops::Range;

/// Square tiles of a level's pixels, anchored at the plate's top-left outer corner, or at the optical axis.
///
/// Tiles and nodes depend on the plate alone, not on the part to render. Grids of the plate's crops are anchored at the optical axis. A
/// crop grows and shrinks with the objects in it; tiles anchored at the crop would move along, and the blur of everything else would
/// change. About the axis the kernels of most lenses are mirror images of each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TileGrid {
    /// Pyramid level; its pixels are 2^level plate pixels wide.
    pub(super) level: u32,
    /// Side of a tile, pixels of the level.
    pub(super) tile: usize,
    /// Position of node 0 along x and y, pixels of the level: 0, or before the plate by less than a tile.
    pub(super) origin: [i32; 2],
    /// Index of the last node along x and y: all sources lie between nodes 0 and this one.
    pub(super) last: [i32; 2],
}

/// The index of a tile of a grid, or of the node at its top-left corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct GridIndex {
    pub(super) row: i32,
    pub(super) column: i32,
}

impl GridIndex {
    pub(super) fn new(row: i32, column: i32) -> Self {
        Self { row, column }
    }

    /// Returns the nodes at the corners of this tile, row by row.
    pub(super) fn corners(self) -> [Self; 4] {
        let Self { row, column } = self;
        [
            self,
            Self::new(row, column + 1),
            Self::new(row + 1, column),
            Self::new(row + 1, column + 1),
        ]
    }
}

/// Interpolation weights of the nodes around each source, for sources at consecutive offsets along one axis.
#[derive(Debug)]
pub(super) struct NodeWeights {
    first: i32,
    weights: Vec<Vec<f32>>,
}

impl TileGrid {
    /// The grid of tiles with sides of `tile` pixels at `level` over a plate of `size`.
    pub(super) fn new(level: u32, tile: usize, size: Size) -> Self {
        Self::beginning(level, tile, size, [0; 2])
    }

    /// The grid of tiles over the plate of `scene`, anchored at the optical axis, as far as the pixels of the level allow.
    pub(super) fn anchored(level: u32, tile: usize, scene: &Scene) -> Self {
        let size = Size {
            width: scene.width,
            height: scene.height,
        };
        let axis = scene.lens.frame().axis();
        let before = scene.map.place_in_cell_about(axis, tile << level);
        let before = before.map(|px| px >> level);
        Self::beginning(level, tile, size, before)
    }

    /// The grid whose node 0 lies `before` the plate, pixels of the level.
    fn beginning(level: u32, tile: usize, size: Size, before: [usize; 2]) -> Self {
        let sizes = [size.width, size.height];
        let last = |axis: usize| {
            let px = sizes[axis] + (before[axis] << level);
            px.div_ceil(tile << level).max(1) as i32
        };
        Self {
            level,
            tile,
            origin: before.map(|px| -(px as i32)),
            last: [last(0), last(1)],
        }
    }

    /// Returns the first pixel (x, y) of `tile`, pixels of the level.
    pub(super) fn first_pixel(&self, tile: GridIndex) -> [i32; 2] {
        let side = self.tile as i32;
        [
            self.origin[0] + tile.column * side,
            self.origin[1] + tile.row * side,
        ]
    }

    /// Returns the tile that holds a pixel (x, y) of the level.
    pub(super) fn tile_at(&self, pixel: [i32; 2]) -> GridIndex {
        let [column, row] =
            [0, 1].map(|axis| (pixel[axis] - self.origin[axis]).div_euclid(self.tile as i32));
        GridIndex::new(row, column)
    }

    /// Returns the width of one of the level's pixels, plate px.
    pub(super) fn step(&self) -> f64 {
        f64::from(1_u32 << self.level)
    }

    /// Returns the plate point (x, y) of `node`, px from the plate's outer corner.
    pub(super) fn plate_point(&self, node: GridIndex) -> (f64, f64) {
        let [x, y] = self.first_pixel(node).map(f64::from);
        (x * self.step(), y * self.step())
    }

    /// Returns the plate columns that `tile` covers.
    pub(super) fn plate_columns(&self, tile: GridIndex) -> Range<i32> {
        let [x, _] = self.first_pixel(tile);
        x << self.level..(x + self.tile as i32) << self.level
    }

    /// Returns the plate rows that `tile` covers.
    pub(super) fn plate_rows(&self, tile: GridIndex) -> Range<i32> {
        let [_, y] = self.first_pixel(tile);
        y << self.level..(y + self.tile as i32) << self.level
    }

    /// Returns the weights of the nodes along `axis` for sources at `offsets`, pixels of the level from node `corner`.
    ///
    /// Sources are interpolated by the cubic (Lagrange) polynomial through the four nodes around them, by a lower
    /// degree on smaller grids, and by the nearest four nodes at the plate's edge. Weights extend one tile beyond the
    /// last nodes: there are no sources, but the stencil of a corner must be right half way to the next.
    pub(super) fn interpolation_weights(
        &self,
        axis: usize,
        corner: i32,
        offsets: Range<i32>,
    ) -> NodeWeights {
        let last = self.last[axis];
        let count = (last + 1).min(4);
        let node_of = |offset: i32| {
            let at = f64::from(corner) + f64::from(offset) / self.tile as f64;
            at.clamp(-1.0, f64::from(last + 1))
        };
        let base_of = |at: f64| ((at.floor() as i32) - 1).clamp(0, last + 1 - count);
        let first = base_of(node_of(offsets.start));
        let end = base_of(node_of(offsets.end - 1)) + count;
        let mut weights = vec![vec![0.0_f32; offsets.len()]; (end - first) as usize];
        for (slot, offset) in offsets.clone().enumerate() {
            let at = node_of(offset);
            let base = base_of(at);
            for k in 0..count {
                let others = (0..count).filter(|other| *other != k);
                let weight: f64 = others
                    .map(|other| (at - f64::from(base + other)) / f64::from(k - other))
                    .product();
                weights[(base + k - first) as usize][slot] = weight as f32;
            }
        }
        NodeWeights { first, weights }
    }
}

impl NodeWeights {
    /// Returns the nodes with a weight in any source.
    pub(super) fn nodes(&self) -> Range<i32> {
        self.first..self.first + self.weights.len() as i32
    }

    /// Returns the weights of `node` for the sources at all offsets.
    pub(super) fn of(&self, node: i32) -> &[f32] {
        &self.weights[(node - self.first) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_is_exact_for_cubics() {
        let size = Size {
            width: 100,
            height: 40,
        };
        let grid = TileGrid::new(0, 16, size);
        assert_eq!(grid.last, [7, 3]);
        let cubic = |x: f64| 1.0 + 0.5 * x - 0.3 * x * x + 0.07 * x * x * x;
        for corner in -1..=8 {
            let weights = grid.interpolation_weights(0, corner, -21..30);
            for offset in -21..30 {
                let at = (f64::from(corner) + f64::from(offset) / 16.0).clamp(-1.0, 8.0);
                let interpolated: f64 = weights
                    .nodes()
                    .map(|n| f64::from(weights.of(n)[(offset + 21) as usize]) * cubic(f64::from(n)))
                    .sum();
                assert!(
                    (interpolated - cubic(at)).abs() < 1e-4,
                    "{corner} {offset}: {interpolated}"
                );
            }
        }
    }
}
