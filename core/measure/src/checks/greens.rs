//! The two greens of a mosaic: equal if the stated pattern is right.

use std::ops::Range;

use seidel_optics::numeric::quantile;

use super::{Concern, Severity};
use crate::photograph::Photograph;

/// Side of a block without clipped pixels, px, and the number of cells along an axis that show the error.
const SIDE: usize = 48;
const CELLS: usize = 4;
/// Share of the pixels that are taken as dark.
const DARK_SHARE: f64 = 0.25;
/// Difference of the logarithms of two greens that no sensor has, and its least multiple of its own error.
const MAX_DIFFERENCE: f64 = 0.08;
const MIN_SIGMAS: f64 = 5.0;

/// Returns the logarithm of the light of the second green of the mosaic over that of the first, and its standard deviation; `None`
/// without two greens or without light.
pub fn difference_of_greens(photo: &Photograph) -> Option<(f64, f64)> {
    let mosaic = photo.mosaic?;
    let greens: Vec<usize> = (0..4).filter(|k| mosaic.is_of("G", k % 2, k / 2)).collect();
    let [first, second] = greens[..] else {
        return None;
    };
    let value = |x: usize, y: usize| f64::from(photo.planes[0][y * photo.width + x]);
    let pixels = |phase: usize, columns: Range<usize>, rows: Range<usize>| {
        let is_of = move |x: usize, y: usize| 2 * (y % 2) + x % 2 == phase;
        rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
            .filter(move |(x, y)| is_of(*x, *y))
    };
    // Light above the dark of the frame, so that the black level does not matter.
    let dark = [first, second].map(|phase| {
        let all = pixels(phase, 0..photo.width, 0..photo.height);
        quantile(
            &mut all.map(|(x, y)| value(x, y)).collect::<Vec<_>>(),
            DARK_SHARE,
        )
    });
    let mut cells = [[0.0; 2]; CELLS * CELLS];
    for (left, top) in (0..photo.height)
        .step_by(SIDE)
        .flat_map(|y| (0..photo.width).step_by(SIDE).map(move |x| (x, y)))
    {
        let columns = left..(left + SIDE).min(photo.width);
        let rows = top..(top + SIDE).min(photo.height);
        let is_unusable = |(x, y): (usize, usize)| photo.is_clipped(x, y) || photo.is_bad(x, y);
        let mut both = [first, second]
            .into_iter()
            .flat_map(|phase| pixels(phase, columns.clone(), rows.clone()));
        if both.any(is_unusable) {
            continue;
        }
        let cell = &mut cells[top * CELLS / photo.height * CELLS + left * CELLS / photo.width];
        for (k, phase) in [first, second].into_iter().enumerate() {
            let light =
                pixels(phase, columns.clone(), rows.clone()).map(|(x, y)| value(x, y) - dark[k]);
            cell[k] += light.sum::<f64>();
        }
    }
    let total = |without: Option<usize>| {
        let kept = || {
            cells
                .iter()
                .enumerate()
                .filter(move |(k, _)| Some(*k) != without)
        };
        let sum = |green: usize| kept().map(|(_, cell)| cell[green]).sum::<f64>();
        (sum(1) / sum(0)).ln()
    };
    let all = total(None);
    // The jackknife over the cells.
    let variance: f64 = (0..cells.len())
        .map(|k| (total(Some(k)) - all).powi(2))
        .sum();
    let sigma = variance.sqrt();
    (all.is_finite() && sigma.is_finite()).then_some((all, sigma))
}

/// Returns whether the two greens of `photo` are apart.
pub fn check(photo: &Photograph) -> Option<Concern> {
    let (difference, sigma) = difference_of_greens(photo)?;
    let limit = MAX_DIFFERENCE.max(MIN_SIGMAS * sigma);
    (difference.abs() > limit).then(|| {
        let pattern = photo.mosaic.map_or_else(String::new, |m| m.to_string());
        let shifted = |order: [usize; 4]| -> String {
            order
                .iter()
                .filter_map(|k| pattern.chars().nth(*k))
                .collect()
        };
        Concern::new(
            Severity::Refuse,
            &photo.name,
            format!(
                "is not of the mosaic {pattern}: its two greens differ by {:.0} %",
                100.0 * difference.abs().exp_m1()
            ),
            &format!(
                "state the mosaic: {} if a column was cropped, {} if a row was",
                shifted([1, 0, 3, 2]),
                shifted([2, 3, 0, 1])
            ),
        )
    })
}
