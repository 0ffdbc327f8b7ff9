//! PSFs from dense rays: a square grid of cells over the pupil, each spread over the box of its landing corners.

use std::ops::Range;

use super::pencil::Pencil;
use super::sensor::FineGrid;

/// Cells across the pupil for tiles of a case.
pub(super) const CELLS: usize = 216;
/// Cells across the pupil for the measurement of gaps.
pub(super) const CELLS_COARSE: usize = 88;

/// A bundle of rays over the square from -1 to 1, which contains the open pupil.
pub(super) trait RayBundle {
    /// A traced ray.
    type Ray: Clone;

    /// Returns the frame position that landing points are relative to.
    fn origin(&self) -> [f64; 2];

    /// Returns half the width of the region with light at height `y`, and at least that.
    fn half_width(&self, y: f64) -> f64;

    /// Traces the rays through points of the square.
    fn rays(&self, points: impl Iterator<Item = [f64; 2]>) -> Vec<Self::Ray>;

    /// Returns the landing point of a ray relative to the origin, px.
    fn landing(ray: &Self::Ray) -> [f64; 2];

    /// Returns the light of a cell; 1 for an open one. Rays that do not reach the sensor are allowed where it is 0.
    fn light(&self, cell: &Cell<Self::Ray>) -> f64;
}

/// A cell of the grid.
pub(super) struct Cell<'a, R> {
    /// Middle of the cell in the square.
    pub(super) middle: [f64; 2],
    /// Width in the square.
    pub(super) width: f64,
    /// Rays through its corners: above left, above right, below left, below right.
    pub(super) corners: [&'a R; 4],
}

impl RayBundle for Pencil {
    type Ray = [f64; 2];

    fn origin(&self) -> [f64; 2] {
        self.chief
    }

    fn half_width(&self, y: f64) -> f64 {
        (1.0 - y * y).max(0.0).sqrt()
    }

    fn rays(&self, points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
        points.map(|m| self.slope(m)).collect()
    }

    fn landing(ray: &[f64; 2]) -> [f64; 2] {
        *ray
    }

    fn light(&self, cell: &Cell<[f64; 2]>) -> f64 {
        self.mask.light(cell.middle, cell.width)
    }
}

/// Adds the light of `bundle` to a fine grid centred on the frame position `centre`.
///
/// The bundle's light sums to 1; light outside the grid is lost.
pub(super) fn trace<B: RayBundle>(bundle: &B, centre: [f64; 2], cells: usize, fine: &mut FineGrid) {
    let cell = 2.0 / cells as f64;
    let origin = bundle.origin();
    let offset = [origin[0] - centre[0], origin[1] - centre[1]];
    let corners = |row: usize, columns: Range<usize>| {
        bundle.rays(columns.map(|column| [column, row].map(|k| k as f64 * cell - 1.0)))
    };
    let mut above: Vec<B::Ray> = corners(0, 0..cells + 1);
    let mut below = above.clone();
    let mut light = 0.0;
    for row in 0..cells {
        let y = (row as f64 + 0.5) * cell - 1.0;
        // Columns with light, and one more on each side.
        let reach = bundle.half_width(y) / cell + 2.0;
        let half = cells as f64 / 2.0;
        let first = (half - reach).max(0.0) as usize;
        let last = ((half + reach) as usize).min(cells - 1);
        below[first..last + 2].clone_from_slice(&corners(row + 1, first..last + 2));
        if row > 0 {
            // The row above may have had fewer columns.
            let reach = bundle.half_width(y - cell) / cell + 2.0;
            let known = (half - reach).max(0.0) as usize;
            let end = ((half + reach) as usize).min(cells - 1) + 2;
            for columns in [first..known, end..last + 2] {
                if !columns.is_empty() {
                    above[columns.clone()].clone_from_slice(&corners(row, columns));
                }
            }
        }
        for column in first..=last {
            let x = (column as f64 + 0.5) * cell - 1.0;
            let corners = [
                &above[column],
                &above[column + 1],
                &below[column],
                &below[column + 1],
            ];
            let weight = bundle.light(&Cell {
                middle: [x, y],
                width: cell,
                corners,
            });
            if weight > 0.0 {
                light += weight;
                let [a, b, c, d] = corners.map(B::landing);
                let middle = |i: usize| offset[i] + 0.25 * (a[i] + b[i] + c[i] + d[i]);
                let extent = |i: usize| {
                    0.5 * ((b[i] - a[i] + d[i] - c[i]).abs() + (c[i] - a[i] + d[i] - b[i]).abs())
                };
                fine.add_box([middle(0), middle(1)], [extent(0), extent(1)], weight);
            }
        }
        std::mem::swap(&mut above, &mut below);
    }
    fine.scale(1.0 / light);
}
