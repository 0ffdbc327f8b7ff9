//! The distance of every pixel from the far sides of depth edges.

use rayon::prelude::*;

/// Distance to a neighbour along a row or column, and to a diagonal one, thirds of a pixel: the chamfer distance of Borgefors (1986),
/// within 8 % of the Euclidean one.
const BESIDE: u16 = 3;
const DIAGONAL: u16 = 4;

/// Distances of the pixels of a plate from the nearest marked pixel.
pub(super) struct EdgeDistance {
    /// Thirds of a pixel, row-major.
    thirds: Vec<u16>,
}

impl EdgeDistance {
    /// Measures the distances from the pixels that `weights`, rows of `width`, mark with values above zero.
    pub(super) fn new(weights: &[f32], width: usize) -> Self {
        let mut thirds: Vec<u16> = weights
            .par_iter()
            .map(|weight| if *weight > 0.0 { 0 } else { u16::MAX })
            .collect();
        let width = width.max(1);
        for start in (0..thirds.len()).step_by(width) {
            let (above, row) = thirds.split_at_mut(start);
            let row = &mut row[..width];
            lower_by_row(row, &above[start.saturating_sub(width)..]);
            lower_along(row.iter_mut());
        }
        for start in (0..thirds.len()).step_by(width).rev() {
            let (row, below) = thirds[start..].split_at_mut(width);
            lower_by_row(row, &below[..width.min(below.len())]);
            lower_along(row.iter_mut().rev());
        }
        Self { thirds }
    }

    /// Returns the distance of pixel `index`, px; more than 21,000 without any edge.
    pub(super) fn px(&self, index: usize) -> f32 {
        f32::from(self.thirds[index]) / f32::from(BESIDE)
    }
}

/// Lowers the distances of `row` by way of the three pixels next to each in the row `finished`, empty at the border.
///
/// Three passes without a branch, so that the compiler uses vector instructions.
fn lower_by_row(row: &mut [u16], finished: &[u16]) {
    if finished.is_empty() {
        return;
    }
    let lower =
        |own: &mut u16, other: &u16, step: u16| *own = (*own).min(other.saturating_add(step));
    for (own, middle) in row.iter_mut().zip(finished) {
        lower(own, middle, BESIDE);
    }
    for (own, before) in row[1..].iter_mut().zip(finished) {
        lower(own, before, DIAGONAL);
    }
    for (own, after) in row.iter_mut().zip(&finished[1..]) {
        lower(own, after, DIAGONAL);
    }
}

/// Lowers each of the distances by way of the one before it.
fn lower_along<'a>(row: impl Iterator<Item = &'a mut u16>) {
    let mut before = u16::MAX;
    for own in row {
        *own = (*own).min(before.saturating_add(BESIDE));
        before = *own;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    #[test]
    fn distances_are_those_by_brute_force() {
        const SIZE: [usize; 2] = [37, 23];
        let mut random = SplitMix64::new(3);
        let mut weights = vec![0.0; SIZE[0] * SIZE[1]];
        for _ in 0..5 {
            let index = (random.unit() * weights.len() as f64) as usize;
            weights[index] = 1.0;
        }
        let found = EdgeDistance::new(&weights, SIZE[0]);
        let place = |index: usize| [(index % SIZE[0]) as f64, (index / SIZE[0]) as f64];
        for index in 0..weights.len() {
            let [x, y] = place(index);
            let marked = (0..weights.len()).filter(|other| weights[*other] > 0.0);
            let nearest = marked
                .map(|other| (place(other)[0] - x).hypot(place(other)[1] - y))
                .fold(f64::INFINITY, f64::min);
            let own = f64::from(found.px(index));
            assert!((own - nearest).abs() <= 0.08 * nearest, "{own} {nearest}");
        }
    }

    #[test]
    fn without_edges_all_is_far() {
        let found = EdgeDistance::new(&[0.0; 12], 4);
        assert!((0..12).all(|index| found.px(index) > 1e4));
    }
}
