//! Correlation of the noise of neighbouring pixels. A sensor's noise has none; interpolated colours, noise reduction and
//! enlargement make it positive, sharpening negative.

use rayon::prelude::*;
use seidel_optics::numeric::quantile;

use super::{Concern, Severity};
use crate::photograph::{Photograph, SampleErrors};

/// Side of a block, samples of one colour: small enough to lie between lights.
const SIDE: usize = 12;
/// Distances of the samples that are compared.
const APART: [usize; 3] = [1, 2, 6];
/// Share of the blocks, the least noisy ones, that show noise and no structure.
const QUIET_SHARE: f64 = 0.25;
/// Blocks that are needed.
const MIN_BLOCKS: usize = 16;
/// Largest departure from the mean of a block without structure, standard deviations.
const MAX_SIGMAS: f64 = 6.0;
/// Least standard deviation of noise that rounding does not hide, in steps between values.
const MIN_QUANTA: f64 = 0.4;
/// Correlations from which on a photograph was processed. Those of simulated raw photographs stay below 0.04, colours
/// interpolated bilinearly have 0.4 to 0.7, a median of 3 x 3 pixels 0.6.
const MIN_CORRELATION: f64 = 0.2;
const MIN_SHARPENED: f64 = -0.08;
/// Correlation at two pixels from which on more than the gaps of a mosaic was filled.
const MIN_SECOND: f64 = 0.35;
/// Correlation far apart, over that of neighbours, from which on a photograph shows structure in place of noise.
const MAX_FAR: f64 = 0.3;

/// Correlation of the noise of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseCorrelation {
    /// Of neighbours of one colour: along rows or columns, whichever is nearer to zero.
    pub neighbours: f64,
    /// Of those two apart.
    pub second: f64,
    /// Of those six apart, where processing no longer reaches, but out-of-focus structure does.
    pub far: f64,
}

#[derive(Clone, Copy)]
struct Sums {
    square: f64,
    /// Products along rows and columns, at the distances of [`APART`].
    products: [[f64; 3]; 2],
}

/// Returns the correlation of the noise of `channel` in the quiet parts of `photo`; `None` where noise is not visible there.
pub fn noise_correlation(photo: &Photograph, channel: usize) -> Option<NoiseCorrelation> {
    let step = if photo.mosaic.is_some() { 2 } else { 1 };
    let plane = &photo.planes[photo.plane_of(channel)];
    let phases = (0..step * step).map(|k| (k % step, k / step));
    let phases: Vec<(usize, usize)> = phases
        .filter(|(x, y)| photo.covers(channel, *x, *y))
        .collect();
    let side = SIDE * step;
    let (columns, rows) = (photo.width / side, photo.height / side);
    let least = (MIN_QUANTA * photo.errors.quantum).powi(2);
    let mut blocks: Vec<Sums> = (0..columns * rows)
        .into_par_iter()
        .flat_map_iter(|block| phases.iter().map(move |phase| (block, *phase)))
        .filter_map(|(block, (px, py))| {
            let (left, top) = (block % columns * side + px, block / columns * side + py);
            let mut values = Vec::with_capacity(SIDE * SIDE);
            for k in 0..SIDE * SIDE {
                let (x, y) = (left + k % SIDE * step, top + k / SIDE * step);
                if photo.is_bad(x, y) || photo.is_clipped(x, y) {
                    return None;
                }
                values.push(f64::from(plane[y * photo.width + x]));
            }
            sums(&values).filter(|sums| sums.square / (SIDE * SIDE) as f64 > least)
        })
        .collect();
    if blocks.len() < MIN_BLOCKS {
        return None;
    }
    let mut squares: Vec<f64> = blocks.iter().map(|b| b.square).collect();
    let limit = quantile(
        &mut squares,
        QUIET_SHARE.max(MIN_BLOCKS as f64 / blocks.len() as f64),
    );
    blocks.retain(|b| b.square <= limit);
    let square: f64 = blocks.iter().map(|b| b.square).sum();
    let correlation = |k: usize| {
        // Samples that have a neighbour so far away, and what the means of rows and columns took.
        let share = (SIDE - APART[k]) as f64 / SIDE as f64;
        let along = |axis: usize| {
            let sum: f64 = blocks.iter().map(|b| b.products[axis][k]).sum();
            sum / (square * share) + 1.0 / (SIDE - 1) as f64
        };
        let (across, down) = (along(0), along(1));
        match across * down > 0.0 {
            true if across.abs() < down.abs() => across,
            true => down,
            false => 0.0,
        }
    };
    Some(NoiseCorrelation {
        neighbours: correlation(0),
        second: correlation(1),
        far: correlation(2),
    })
}

/// Returns the sums of a block, less the means of its rows and columns; `None` where it shows more than noise.
fn sums(values: &[f64]) -> Option<Sums> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let of_row = |y: usize| (0..SIDE).map(|x| values[y * SIDE + x]).sum::<f64>() / SIDE as f64;
    let of_column = |x: usize| (0..SIDE).map(|y| values[y * SIDE + x]).sum::<f64>() / SIDE as f64;
    let (rows, columns): (Vec<f64>, Vec<f64>) =
        (0..SIDE).map(|k| (of_row(k), of_column(k))).unzip();
    let left: Vec<f64> = (values.iter().enumerate())
        .map(|(k, v)| v - rows[k / SIDE] - columns[k % SIDE] + mean)
        .collect();
    let square: f64 = left.iter().map(|v| v * v).sum();
    let largest = left.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    if largest * largest > MAX_SIGMAS * MAX_SIGMAS * square / values.len() as f64 {
        return None;
    }
    let mut products = [[0.0; 3]; 2];
    for y in 0..SIDE {
        for x in 0..SIDE {
            for (k, apart) in APART.into_iter().enumerate() {
                if x + apart < SIDE {
                    products[0][k] += left[y * SIDE + x] * left[y * SIDE + x + apart];
                    products[1][k] += left[x * SIDE + y] * left[(x + apart) * SIDE + y];
                }
            }
        }
    }
    Some(Sums { square, products })
}

/// Returns what the noise of `photo` says about its processing; nothing for files of 8 bits, which are known to be developed.
pub fn check(photo: &Photograph) -> Option<Concern> {
    let channels = 0..photo.channels.len();
    let found = channels.filter_map(|channel| noise_correlation(photo, channel));
    judge(photo, found)
}

/// Returns the concern that the strongest correlation `found` in the channels of `photo` raises.
pub(crate) fn judge(
    photo: &Photograph,
    found: impl Iterator<Item = NoiseCorrelation>,
) -> Option<Concern> {
    if photo.errors.relative >= SampleErrors::EIGHT_BIT.relative {
        return None;
    }
    let found = found.max_by(|a, b| a.neighbours.abs().total_cmp(&b.neighbours.abs()))?;
    let concern = |severity, cause: &str, remedy: &str| {
        let problem = format!(
            "{cause}: the noise of neighbouring pixels has a correlation of {:.2}, that of a sensor has none",
            found.neighbours
        );
        Some(Concern::new(severity, &photo.name, problem, remedy))
    };
    if found.neighbours < MIN_SHARPENED {
        return concern(
            Severity::Refuse,
            "was sharpened",
            "give the raw file, or develop it without sharpening",
        );
    }
    if found.neighbours < MIN_CORRELATION || found.far.abs() > MAX_FAR * found.neighbours {
        return None;
    }
    if photo.mosaic.is_some() {
        return concern(
            Severity::Refuse,
            "was denoised",
            "turn noise reduction of the camera or of the converter off",
        );
    }
    if found.second > MIN_SECOND || photo.channels.len() < 3 {
        return concern(
            Severity::Refuse,
            "was enlarged or denoised",
            "give the raw file, or a development at its own size without noise reduction",
        );
    }
    // Developments state these errors already.
    if photo.errors.relative >= SampleErrors::DEVELOPED.relative {
        return None;
    }
    concern(
        Severity::Widen(SampleErrors::DEVELOPED.relative),
        "has interpolated colours, which widen the blur by up to 0.5 px² of variance; the stated errors are widened",
        "give the raw file",
    )
}
