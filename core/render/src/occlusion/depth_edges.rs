//! Repair of anti-aliased depth edges: values between two surfaces are snapped to one of them.
//!
//! A pixel, or two side by side, on a line across an edge with values between those of the two sides gets the value of
//! the nearer side. The line must be even on both sides of the edge, so steep but smooth slopes and noisy pixels do
//! not change. Depth multiplied by alpha lies beyond both sides and must be unpremultiplied first.

use rayon::prelude::*;

/// Least difference of the sides of an edge, layers.
const LEAST_SPAN: f32 = 2.0;
/// Largest distance of a value that belongs to a side, layers.
const ON_A_SIDE: f32 = 0.5;
/// Largest change of the line beyond either side, as a share of the edge.
const LARGEST_SLOPE: f32 = 0.25;
/// Directions of lines: horizontal, vertical and both diagonals.
const DIRECTIONS: [(i32, i32); 4] = [(1, 0), (0, 1), (1, 1), (1, -1)];
/// Steps from a pixel to either side of an edge one or two pixels wide.
const STEPS: [(i32, i32); 3] = [(1, 1), (1, 2), (2, 1)];

/// Pixels of a row that are tested for any edge together.
const BLOCK: usize = 32;
/// Reach of the test of a pixel, px.
const REACH: usize = 3;

/// Returns layer `coordinates` (row-major) with values in the middle of edges snapped to a side.
pub(crate) fn snapped(coordinates: &[f32], width: usize, height: usize) -> Vec<f32> {
    let spans: Vec<Vec<(f32, f32)>> = coordinates.par_chunks(width).map(spans).collect();
    let mut out = coordinates.to_vec();
    out.par_chunks_mut(width)
        .enumerate()
        .for_each(|(row, out)| {
            let about = &spans[row.saturating_sub(REACH)..(row + REACH + 1).min(height)];
            for (block, out) in out.chunks_mut(BLOCK).enumerate() {
                let ends = about.iter().map(|line| line[block]);
                let (low, high) = ends.fold((f32::INFINITY, f32::NEG_INFINITY), joined);
                if high - low > LEAST_SPAN {
                    snap(out, block * BLOCK, row, coordinates, width);
                }
            }
        });
    out
}

fn joined(a: (f32, f32), b: (f32, f32)) -> (f32, f32) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Returns the smallest and largest value around each block of a row.
fn spans(row: &[f32]) -> Vec<(f32, f32)> {
    let about =
        |start: usize| &row[start.saturating_sub(REACH)..(start + BLOCK + REACH).min(row.len())];
    let span = |start: usize| {
        let values = about(start).iter().map(|v| (*v, *v));
        values.fold((f32::INFINITY, f32::NEG_INFINITY), joined)
    };
    (0..row.len()).step_by(BLOCK).map(span).collect()
}

/// Snaps the pixels of a block that begins at column `first` of `row`.
fn snap(out: &mut [f32], first: usize, row: usize, coordinates: &[f32], width: usize) {
    let height = coordinates.len() / width;
    for (k, coordinate) in out.iter_mut().enumerate() {
        let at = |dx: i32, dy: i32| {
            let x = ((first + k) as i32 + dx).clamp(0, width as i32 - 1) as usize;
            let y = (row as i32 + dy).clamp(0, height as i32 - 1) as usize;
            coordinates[y * width + x]
        };
        if let Some(side) = nearer_side(*coordinate, at) {
            *coordinate = side;
        }
    }
}

/// Returns the value that a pixel with value `here` snaps to; `None` unless it lies in the middle of an edge. Of
/// several edges the largest counts.
fn nearer_side(here: f32, at: impl Fn(i32, i32) -> f32) -> Option<f32> {
    let mut widest: Option<(f32, f32)> = None;
    for (dx, dy) in DIRECTIONS {
        for (back, forth) in STEPS {
            let (one, other) = (at(-back * dx, -back * dy), at(forth * dx, forth * dy));
            let span = (one - other).abs();
            if span <= LEAST_SPAN || widest.is_some_and(|(least, _)| span <= least) {
                continue;
            }
            let between = (here - one) * (here - other) < 0.0;
            let (to_one, to_other) = ((here - one).abs(), (here - other).abs());
            if !between || to_one.min(to_other) <= ON_A_SIDE {
                continue;
            }
            let beyond = |steps: i32, side: f32| (at(steps * dx, steps * dy) - side).abs();
            let slope = beyond(-back - 1, one).max(beyond(forth + 1, other));
            if slope <= LARGEST_SLOPE * span {
                widest = Some((span, if to_one < to_other { one } else { other }));
            }
        }
    }
    widest.map(|(_, side)| side)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a plate 9 px wide with one value per column.
    fn columns(values: [f32; 9]) -> Vec<f32> {
        std::iter::repeat_n(values, 5).flatten().collect()
    }

    fn snapped_row(values: [f32; 9]) -> Vec<f32> {
        snapped(&columns(values), 9, 5)[18..27].to_vec()
    }

    #[test]
    fn values_in_the_middle_of_an_edge_snap_to_the_nearer_side() {
        let got = snapped_row([2.0, 2.0, 2.0, 2.0, 9.0, 12.0, 12.0, 12.0, 12.0]);
        assert_eq!(got, [2.0, 2.0, 2.0, 2.0, 12.0, 12.0, 12.0, 12.0, 12.0]);
        let got = snapped_row([2.0, 2.0, 2.0, 5.0, 9.0, 12.0, 12.0, 12.0, 12.0]);
        assert_eq!(got, [2.0, 2.0, 2.0, 2.0, 12.0, 12.0, 12.0, 12.0, 12.0]);
    }

    #[test]
    fn slopes_wires_and_noise_do_not_change() {
        let slope = [0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0, 21.0, 24.0];
        assert_eq!(snapped_row(slope), slope);
        let wire = [2.0, 2.0, 2.0, 2.0, 9.0, 2.0, 2.0, 2.0, 2.0];
        assert_eq!(snapped_row(wire), wire);
        let mut noisy: Vec<f32> = columns([4.0; 9]);
        for (k, coordinate) in noisy.iter_mut().enumerate() {
            *coordinate += (k * k * 7 % 11) as f32 / 11.0;
        }
        assert_eq!(snapped(&noisy, 9, 5), noisy);
    }
}
