//! Covariance of the fitted parameters.

use nalgebra::{DMatrix, DVector};

use super::context::{FitContext, FittedLens, LENIENT_TOLERANCE};
use super::metric::Metric;
use super::pixel_problem::PixelProblem;

/// A strong correlation between two parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    /// Names of the two parameters.
    pub names: [String; 2],
    /// Correlation coefficient, -1 to 1.
    pub value: f64,
}

/// A linear combination of parameters that the data hardly determine.
#[derive(Debug, Clone, PartialEq)]
pub struct PoorlyDetermined {
    /// Names of the parameters with the largest weights in it.
    pub names: Vec<String>,
    /// Its standard error relative to that of uncorrelated parameters (root of the inverse eigenvalue of the
    /// normalised Fisher information).
    pub inflation: f64,
}

/// Absolute correlation from which on a pair is reported.
const MIN_CORRELATION: f64 = 0.95;
/// Inflation of the standard error from which on a combination is reported.
const MIN_INFLATION: f64 = 30.0;

/// Covariance of the free parameters, with its diagnostics.
pub(super) struct CovarianceEstimate {
    pub(super) covariance: DMatrix<f64>,
    pub(super) correlations: Vec<Correlation>,
    pub(super) poorly_determined: Vec<PoorlyDetermined>,
}

impl CovarianceEstimate {
    /// Estimates the covariance at `fit` over all its tiles.
    ///
    /// Where noise dominates this is the inverse Fisher information. Otherwise it is the sandwich estimator
    /// clustered by tile, because model errors of neighbouring pixels are correlated.
    pub(super) fn of(context: &FitContext, fit: &FittedLens) -> Self {
        let tiles = context.all();
        let problem = PixelProblem {
            layout: &fit.layout,
            tiles: &tiles,
            settings: fit.misfit_settings(LENIENT_TOLERANCE),
        };
        let point = problem.at(fit.theta.clone(), context.tile_parameters(&tiles));
        let (normal, _) = problem.total(&point);
        let count = normal.nrows();
        let inverse = inverse(&normal);
        let covariance = if fit.metric == Metric::Pixels && tiles.iter().all(|t| t.sigma > 0.0) {
            // Tiles that differ by noise alone count in full.
            inverse * point.weight_of_noise()
        } else {
            // Sum over tiles of the outer products of the scores.
            let mut scores = DMatrix::zeros(count, count);
            for (tile, weight) in problem.equations(&point).iter().zip(point.weights()) {
                let mut score = DVector::zeros(count);
                for (&slot, right) in tile.lens.parameters.iter().zip(&tile.lens.right) {
                    score[slot] = weight * right;
                }
                scores += &score * score.transpose();
            }
            let tiles = tiles.len() as f64;
            let freedom = (tiles - count as f64).max(1.0);
            &inverse * scores * &inverse * (tiles / freedom)
        };
        let names: Vec<String> = (0..count)
            .map(|k| fit.layout.name(k, context.channel_names()))
            .collect();
        Self {
            correlations: correlations(&covariance, &names),
            poorly_determined: poorly_determined(&normal, &names),
            covariance,
        }
    }
}

/// Returns the pseudo-inverse of a normal matrix; parameters without influence get zero.
fn inverse(normal: &DMatrix<f64>) -> DMatrix<f64> {
    let count = normal.nrows();
    let root: Vec<f64> = (0..count).map(|k| normal[(k, k)].max(0.0).sqrt()).collect();
    let scaled = DMatrix::from_fn(count, count, |a, b| {
        let size = root[a] * root[b];
        if size > 0.0 {
            normal[(a, b)] / size
        } else if a == b {
            1.0
        } else {
            0.0
        }
    });
    let inverse = scaled
        .pseudo_inverse(1e-12)
        .unwrap_or_else(|_| DMatrix::zeros(count, count));
    DMatrix::from_fn(count, count, |a, b| {
        let size = root[a] * root[b];
        if size > 0.0 {
            inverse[(a, b)] / size
        } else {
            0.0
        }
    })
}

fn correlations(covariance: &DMatrix<f64>, names: &[String]) -> Vec<Correlation> {
    let mut found = Vec::new();
    for a in 0..names.len() {
        for b in a + 1..names.len() {
            let size = (covariance[(a, a)] * covariance[(b, b)]).sqrt();
            let value = covariance[(a, b)] / size;
            if value.abs() >= MIN_CORRELATION {
                found.push(Correlation {
                    names: [names[a].clone(), names[b].clone()],
                    value,
                });
            }
        }
    }
    found.sort_by(|a, b| b.value.abs().total_cmp(&a.value.abs()));
    found
}

fn poorly_determined(normal: &DMatrix<f64>, names: &[String]) -> Vec<PoorlyDetermined> {
    let used: Vec<usize> = (0..names.len()).filter(|&k| normal[(k, k)] > 0.0).collect();
    let scaled = DMatrix::from_fn(used.len(), used.len(), |a, b| {
        let (i, j) = (used[a], used[b]);
        normal[(i, j)] / (normal[(i, i)] * normal[(j, j)]).sqrt()
    });
    let eigen = scaled.symmetric_eigen();
    let mut found: Vec<PoorlyDetermined> = eigen
        .eigenvalues
        .iter()
        .enumerate()
        .filter_map(|(k, value)| {
            let inflation = 1.0 / value.max(1e-12).sqrt();
            (inflation > MIN_INFLATION).then(|| {
                let direction = eigen.eigenvectors.column(k);
                let largest = direction.amax();
                PoorlyDetermined {
                    names: used
                        .iter()
                        .zip(direction.iter())
                        .filter(|(_, share)| share.abs() > 0.3 * largest)
                        .map(|(&slot, _)| names[slot].clone())
                        .collect(),
                    inflation,
                }
            })
        })
        .collect();
    found.sort_by(|a, b| b.inflation.total_cmp(&a.inflation));
    found
}
