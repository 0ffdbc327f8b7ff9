//! How well the data fix the numbers of a lens.

use nalgebra::{DMatrix, DVector};

use super::descent::Problem;
use super::job::{Fitted, Job, LENIENT};
use super::metric::Metric;

/// Two numbers that the data let trade off against each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Correlation {
    /// The two, by name.
    pub names: [String; 2],
    /// Their correlation, from -1 to 1.
    pub value: f64,
}

/// A combination of numbers that the data hardly fix.
#[derive(Debug, Clone, PartialEq)]
pub struct Unclear {
    /// The numbers with most weight in it.
    pub names: Vec<String>,
    /// By how much it is less well fixed than if all numbers were independent.
    pub times: f64,
}

/// Correlations from here on are told.
const TELLING: f64 = 0.95;
/// A combination this many times less well fixed than independent numbers would be is told.
const UNCLEAR: f64 = 30.0;

/// Covariance of a fit's free numbers.
pub(super) struct Errors {
    pub(super) covariance: DMatrix<f64>,
    pub(super) correlations: Vec<Correlation>,
    pub(super) unclear: Vec<Unclear>,
}

impl Errors {
    /// Of `fit` on all its tiles. Where noise decides, from the noise; else from how tiles differ in
    /// what they ask for, for the misfit of neighbouring pixels is no noise.
    pub(super) fn of(job: &Job, fit: &Fitted) -> Self {
        let tiles = job.all();
        let comparison = fit.comparison(LENIENT);
        let problem = Problem {
            layout: &fit.layout,
            tiles: &tiles,
            comparison,
        };
        let still = super::descent::Patience {
            steps: 0,
            fall: 0.0,
        };
        let settled = problem.descend(job.state(&tiles, &fit.theta), still);
        let (normal, _) = problem.total(&settled.systems, &settled.weights);
        let count = normal.nrows();
        let inverse = inverse(&normal);
        let covariance = if fit.metric == Metric::Pixels && tiles.iter().all(|t| t.sigma > 0.0) {
            inverse
        } else {
            let mut asked = DMatrix::zeros(count, count);
            for (system, weight) in settled.systems.iter().zip(&settled.weights) {
                let mut right = DVector::zeros(count);
                for (a, &slot) in system.slots.iter().enumerate() {
                    right[slot] = weight * system.right[a];
                }
                asked += &right * right.transpose();
            }
            let tiles = tiles.len() as f64;
            let spare = (tiles - count as f64).max(1.0);
            &inverse * asked * &inverse * (tiles / spare)
        };
        let names: Vec<String> = (0..count)
            .map(|k| fit.layout.name(k, job.channel_names()))
            .collect();
        Self {
            correlations: correlations(&covariance, &names),
            unclear: unclear(&normal, &names),
            covariance,
        }
    }
}

/// Inverse of a normal matrix; numbers that nothing depends on get zero.
fn inverse(normal: &DMatrix<f64>) -> DMatrix<f64> {
    let count = normal.nrows();
    let root: Vec<f64> = (0..count).map(|k| normal[(k, k)].max(0.0).sqrt()).collect();
    let scaled = DMatrix::from_fn(count, count, |a, b| {
        let size = root[a] * root[b];
        match (size > 0.0, a == b) {
            (true, _) => normal[(a, b)] / size,
            (false, true) => 1.0,
            (false, false) => 0.0,
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
            if value.abs() >= TELLING {
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

fn unclear(normal: &DMatrix<f64>, names: &[String]) -> Vec<Unclear> {
    let used: Vec<usize> = (0..names.len()).filter(|&k| normal[(k, k)] > 0.0).collect();
    let scaled = DMatrix::from_fn(used.len(), used.len(), |a, b| {
        let (i, j) = (used[a], used[b]);
        normal[(i, j)] / (normal[(i, i)] * normal[(j, j)]).sqrt()
    });
    let eigen = scaled.symmetric_eigen();
    let mut found: Vec<Unclear> = eigen
        .eigenvalues
        .iter()
        .enumerate()
        .filter_map(|(k, value)| {
            let times = 1.0 / value.max(1e-12).sqrt();
            (times > UNCLEAR).then(|| {
                let direction = eigen.eigenvectors.column(k);
                let largest = direction.amax();
                Unclear {
                    names: used
                        .iter()
                        .zip(direction.iter())
                        .filter(|(_, share)| share.abs() > 0.3 * largest)
                        .map(|(&slot, _)| names[slot].clone())
                        .collect(),
                    times,
                }
            })
        })
        .collect();
    found.sort_by(|a, b| b.times.total_cmp(&a.times));
    found
}
