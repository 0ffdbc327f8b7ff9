//! Starting values of chief-ray shifts from observed centroids.
//!
//! Levenberg-Marquardt on pixels finds a shift only if the predicted and the observed PSF overlap. Shifts of many pixels,
//! such as those of strong distortion, are therefore estimated from centroids first.

use nalgebra::{DMatrix, DVector};

use super::hypothesis::Hypothesis;
use super::registration::Registration;
use super::tiles::TileData;
use seidel_optics::numeric::median;

/// Root mean square offset of observed from predicted centroids from which on shifts are estimated by centroids, px.
const MIN_OFFSET_PX: f64 = 1.0;
/// Ridge relative to the mean diagonal element of the normal matrix.
const RIDGE: f64 = 1e-6;
/// Passes of the reweighted least squares, and the offset beyond which the weight of a centroid falls, in medians.
const PASSES: usize = 3;
const OUTLIER_MEDIANS: f64 = 3.0;

/// Returns whether the centroids of `tiles` lie far from those that `nothing` predicts.
pub(super) fn are_displaced(nothing: &Hypothesis, tiles: &[&TileData]) -> bool {
    let offsets = tiles.iter().filter_map(|t| offset(nothing, &[], t));
    let squares: Vec<f64> = offsets.map(|[x, y]| x * x + y * y).collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    mean.sqrt() > MIN_OFFSET_PX
}

/// Returns whether `theta` has a value that shifts chief rays only beside another one, as the keystone of a tilt does: gradients at
/// `neutral` do not lead to it.
pub(super) fn is_carried(
    hypothesis: &Hypothesis,
    theta: &[f64],
    neutral: &[f64],
    tiles: &[&TileData],
) -> bool {
    let shows_shifts = tiles.iter().any(|tile| tile.centroid.is_some());
    shows_shifts
        && (0..theta.len()).any(|k| {
            !shifts_chief_ray(hypothesis, neutral, k, tiles)
                && shifts_chief_ray(hypothesis, theta, k, tiles)
        })
}

/// Returns `theta` with those of its values that shift chief rays set such that the predicted centroids of `tiles` agree with
/// the observed ones, by reweighted linear least squares.
pub(super) fn with_placed_centroids(
    hypothesis: &Hypothesis,
    theta: &[f64],
    tiles: &[&TileData],
) -> Vec<f64> {
    let shifting: Vec<usize> = (0..theta.len())
        .filter(|k| shifts_chief_ray(hypothesis, theta, *k, tiles))
        .collect();
    let mut theta = theta.to_vec();
    if shifting.is_empty() {
        return theta;
    }
    let used: Vec<&&TileData> = (tiles.iter())
        .filter(|t| offset(hypothesis, &theta, t).is_some())
        .collect();
    if used.is_empty() {
        return theta;
    }
    for _ in 0..PASSES {
        let offsets: Vec<[f64; 2]> = (used.iter())
            .filter_map(|t| offset(hypothesis, &theta, t))
            .collect();
        let mut sizes: Vec<f64> = offsets.iter().map(|[x, y]| x.hypot(*y)).collect();
        let limit = OUTLIER_MEDIANS * median(&mut sizes) + 1e-9;
        let n = shifting.len();
        let mut normal: DMatrix<f64> = DMatrix::zeros(n, n);
        let mut right = DVector::zeros(n);
        for (tile, here) in used.iter().zip(&offsets) {
            let weight = (limit / here[0].hypot(here[1]).max(limit)).min(1.0);
            let rates: Vec<[f64; 2]> = (shifting.iter())
                .map(|&k| {
                    let step = hypothesis.slots[k].step;
                    let mut moved = theta.clone();
                    moved[k] += step;
                    let there = offset(hypothesis, &moved, tile).unwrap_or(*here);
                    [0, 1].map(|axis| (here[axis] - there[axis]) / step)
                })
                .collect();
            for (i, a) in rates.iter().enumerate() {
                right[i] += weight * (a[0] * here[0] + a[1] * here[1]);
                for (j, b) in rates.iter().enumerate() {
                    normal[(i, j)] += weight * (a[0] * b[0] + a[1] * b[1]);
                }
            }
        }
        let ridge = RIDGE * normal.diagonal().sum() / n as f64;
        let Some(factors) = (normal + DMatrix::identity(n, n) * ridge).cholesky() else {
            return theta;
        };
        for (&k, step) in shifting.iter().zip(factors.solve(&right).iter()) {
            let slot = &hypothesis.slots[k];
            theta[k] = (theta[k] + step).clamp(slot.least, slot.most);
        }
    }
    theta
}

/// Returns the observed centroid of `tile` less the predicted one, px; `None` if its place is not known.
fn offset(hypothesis: &Hypothesis, theta: &[f64], tile: &TileData) -> Option<[f64; 2]> {
    let observed = tile.centroid?;
    let values = hypothesis.values(theta, tile.of_lens);
    let (pupil, moved) = hypothesis.act(&values, tile);
    let common = match &tile.registration {
        Registration::Ideal => [0.0; 2],
        Registration::Reference(reference) => hypothesis.reference_shift(&values, reference),
        Registration::Centroid => return None,
    };
    let centroid = pupil.centroid();
    Some([0, 1].map(|axis| observed[axis] - centroid[axis] - moved[axis] + common[axis]))
}

/// Returns whether value `k` shifts the chief ray of a tile.
fn shifts_chief_ray(hypothesis: &Hypothesis, theta: &[f64], k: usize, tiles: &[&TileData]) -> bool {
    let mut there = theta.to_vec();
    there[k] += hypothesis.slots[k].step;
    tiles.iter().any(|tile| {
        let at = |theta: &[f64]| {
            hypothesis
                .act(&hypothesis.values(theta, tile.of_lens), tile)
                .1
        };
        at(theta) != at(&there)
    })
}
