//! The grid of nodes at one pyramid level: where the lens is asked, and how its answers are joined.

use std::ops::Range;

/// Square tiles of a level's pixels, anchored at the plate's top-left outer corner, and the nodes at
/// their corners. Where tiles and nodes lie depends on the plate alone, not on what part is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Grid {
    /// Pyramid level: a pixel of it is 2^level plate pixels wide.
    pub(super) level: u32,
    /// Side of a tile, pixels of the level.
    pub(super) tile: usize,
    /// Index of the last node that a source can lie before, along x and y: sources lie within nodes 0
    /// to this one.
    pub(super) last: [i32; 2],
}

/// Weights of the nodes about a source, for all offsets along one axis.
#[derive(Debug)]
pub(super) struct Shares {
    first: i32,
    weights: Vec<Vec<f32>>,
}

impl Grid {
    pub(super) fn new(level: u32, tile: usize, (width, height): (usize, usize)) -> Self {
        let side = tile << level;
        Self {
            level,
            tile,
            last: [width, height].map(|size| size.div_ceil(side).max(1) as i32),
        }
    }

    /// Plate pixels that make up one of the level's.
    pub(super) fn step(&self) -> f64 {
        f64::from(1_u32 << self.level)
    }

    /// Plate point of node (`x`, `y`), px from the outer corner.
    pub(super) fn node_at(&self, x: i32, y: i32) -> (f64, f64) {
        let side = (self.tile << self.level) as f64;
        (f64::from(x) * side, f64::from(y) * side)
    }

    /// How the nodes along `axis` share in sources at `offsets` (pixels of the level) from node
    /// `corner`: the cubic through the four nodes about a source, fewer on a grid that has fewer; the
    /// nearest four where a source is at the plate's edge. They go on for a tile beyond the last nodes:
    /// there are no sources, but a corner's stencil has to hold what makes it right half way to the next.
    pub(super) fn shares(&self, axis: usize, corner: i32, offsets: Range<i32>) -> Shares {
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
        Shares { first, weights }
    }
}

impl Shares {
    /// Nodes that share in any source.
    pub(super) fn nodes(&self) -> Range<i32> {
        self.first..self.first + self.weights.len() as i32
    }

    /// The weights of `node` for sources at all offsets.
    pub(super) fn of(&self, node: i32) -> &[f32] {
        &self.weights[(node - self.first) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_between_nodes_are_exact() {
        let grid = Grid::new(0, 16, (100, 40));
        assert_eq!(grid.last, [7, 3]);
        let cubic = |x: f64| 1.0 + 0.5 * x - 0.3 * x * x + 0.07 * x * x * x;
        for corner in -1..=8 {
            let shares = grid.shares(0, corner, -21..30);
            for offset in -21..30 {
                let at = (f64::from(corner) + f64::from(offset) / 16.0).clamp(-1.0, 8.0);
                let joined: f64 = shares
                    .nodes()
                    .map(|n| f64::from(shares.of(n)[(offset + 21) as usize]) * cubic(f64::from(n)))
                    .sum();
                assert!(
                    (joined - cubic(at)).abs() < 1e-4,
                    "{corner} {offset}: {joined}"
                );
            }
        }
    }
}
