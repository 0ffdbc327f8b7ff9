//! PSFs from dense rays: a square grid of cells over the pupil, each spread over the box of its landing corners.

use super::pencil::Pencil;
use super::sensor::FineGrid;

/// Cells across the pupil for tiles of a case.
pub(super) const CELLS: usize = 216;
/// Cells across the pupil for the measurement of gaps.
pub(super) const CELLS_COARSE: usize = 88;

/// Adds the light of `pencil` to a fine grid centred on the frame position `centre`.
///
/// The pencil's light sums to 1; light outside the grid is lost.
pub(super) fn trace(pencil: &Pencil, centre: [f64; 2], cells: usize, fine: &mut FineGrid) {
    let cell = 2.0 / cells as f64;
    let offset = [pencil.chief[0] - centre[0], pencil.chief[1] - centre[1]];
    let corner = |row: usize, column: usize| {
        pencil.slope([column as f64 * cell - 1.0, row as f64 * cell - 1.0])
    };
    let mut above: Vec<[f64; 2]> = (0..=cells).map(|column| corner(0, column)).collect();
    let mut below = above.clone();
    let mut light = 0.0;
    for row in 0..cells {
        let y = (row as f64 + 0.5) * cell - 1.0;
        // Columns within the disc, and one more on each side.
        let reach = (1.0 - y * y).max(0.0).sqrt() / cell + 2.0;
        let half = cells as f64 / 2.0;
        let first = (half - reach).max(0.0) as usize;
        let last = ((half + reach) as usize).min(cells - 1);
        for (column, at) in below.iter_mut().enumerate().take(last + 2).skip(first) {
            *at = corner(row + 1, column);
        }
        if row > 0 {
            // The row above may have had fewer columns.
            let y_above = y - cell;
            let reach = (1.0 - y_above * y_above).max(0.0).sqrt() / cell + 2.0;
            let known =
                (half - reach).max(0.0) as usize..=((half + reach) as usize).min(cells - 1) + 1;
            for (column, at) in above.iter_mut().enumerate().take(last + 2).skip(first) {
                if !known.contains(&column) {
                    *at = corner(row, column);
                }
            }
        }
        for column in first..=last {
            let x = (column as f64 + 0.5) * cell - 1.0;
            let weight = pencil.mask.light([x, y], cell);
            if weight > 0.0 {
                light += weight;
                let (a, b, c, d) = (
                    above[column],
                    above[column + 1],
                    below[column],
                    below[column + 1],
                );
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
