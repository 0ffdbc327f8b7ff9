//! Variances of edges that carry blur of their own: maximum likelihood of a mixture, by expectation-maximisation (EM).
//!
//! The variance of edge i along its normal is `row_i . S + b_i + e_i`: that of the lens, the blur of the scene itself (soft
//! shadows, round corners, depth) and the error of the measurement. The scene adds b_i = 0 with probability p, otherwise an
//! exponential of mean m: the lens is the lower envelope of the variances. An edge in `OUTLIERS` has a far larger error.

use nalgebra::{SMatrix, SVector};
use seidel_optics::numeric::{StandardNormal, dot, median, quantile};

/// Unknown coefficients of the lens.
pub(super) const UNKNOWNS: usize = 5;
/// Share of edges with an error `OUTLIER_SCALE` times as large.
const OUTLIERS: f64 = 0.02;
const OUTLIER_SCALE: f64 = 5.0;
/// Least mean of the scene's blur over the median error of an edge: less cannot be distinguished from it.
const LEAST_MEAN: f64 = 1.5;
/// Share of the edges below the first estimate of the envelope.
const START_QUANTILE: f64 = 0.05;
/// Share that counts as none.
const NO_SHARE: f64 = 1e-3;
const MAX_ITERATIONS: usize = 300;
/// Factors on the error that are compared, and the gain of the log-likelihood that a larger one must bring.
const NOISE_STEPS: [f64; 5] = [1.0, 1.3, 1.7, 2.2, 3.0];
const NOISE_GAIN: f64 = 2.0;
/// Log-likelihood per edge below which an iteration gains nothing.
const MIN_GAIN: f64 = 1e-7;

/// The variance of an edge along its normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    /// Derivatives of the lens's variance by its coefficients.
    pub(super) row: [f64; UNKNOWNS],
    /// Measured variance, px².
    pub(super) value: f64,
    /// Stated standard deviation, px².
    pub(super) sigma: f64,
}

impl Sample {
    pub(super) fn lens(&self, s: &[f64; UNKNOWNS]) -> f64 {
        dot(&self.row, s)
    }
}

/// Estimated blur of the scene at an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OwnBlur {
    /// Probability that the edge is sharp.
    pub(super) sharp: f64,
    /// Expected variance, px², and the variance of that estimate, px⁴.
    pub(super) mean: f64,
    pub(super) spread: f64,
    /// Weight of the edge, one over the square of its error, px⁻⁴.
    weight: f64,
}

/// The lens and the scene that explain the variances best.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mixture {
    /// Coefficients of the lens.
    pub(super) s: [f64; UNKNOWNS],
    /// Share of sharp edges.
    pub(super) sharp_share: f64,
    /// Mean variance of the scene's blur where there is one, px².
    pub(super) mean_px2: f64,
    /// True over stated error of a variance.
    pub(super) noise_scale: f64,
    pub(super) log_likelihood: f64,
}

/// Edges that the scene may blur.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Softness {
    /// Some of them: the share of sharp edges is estimated.
    Some,
    /// All of them: none is sharp.
    All,
}

/// Fits the mixture to `samples`, whose true errors are at least `noise_scale` times the stated ones: errors that all channels
/// share do not show in their differences, from which it comes. A larger scale is taken where it is far more likely. `None` if
/// the samples do not determine the coefficients.
pub(super) fn fit(samples: &[Sample], noise_scale: f64, softness: Softness) -> Option<Mixture> {
    let start = envelope(samples)?;
    let mut best: Option<Mixture> = None;
    for step in NOISE_STEPS {
        let start = Mixture {
            noise_scale: step * noise_scale,
            ..start.clone()
        };
        let Some(found) = refine(samples, start, softness) else {
            continue;
        };
        let gain = |best: &Mixture| found.log_likelihood - best.log_likelihood;
        if best.as_ref().is_none_or(|best| gain(best) > NOISE_GAIN) {
            best = Some(found);
        }
    }
    best
}

/// Improves `mixture` by EM.
pub(super) fn refine(
    samples: &[Sample],
    mut mixture: Mixture,
    softness: Softness,
) -> Option<Mixture> {
    if softness == Softness::All {
        mixture.sharp_share = NO_SHARE;
    }
    let mut sigmas: Vec<f64> = samples.iter().map(|s| s.sigma).collect();
    let typical = median(&mut sigmas);
    let mut own = vec![];
    for _ in 0..MAX_ITERATIONS {
        let before = mixture.log_likelihood;
        mixture.log_likelihood = own_blurs(&mixture, samples, &mut own);
        if (mixture.log_likelihood - before).abs() < MIN_GAIN * samples.len() as f64 {
            break;
        }
        let targets: Vec<f64> = (samples.iter().zip(&own))
            .map(|(s, o)| s.value - o.mean)
            .collect();
        let weights: Vec<f64> = own.iter().map(|o| o.weight).collect();
        mixture.s = solve(samples, &targets, &weights)?;
        let sharp: f64 = own.iter().map(|o| o.sharp).sum();
        let soft = samples.len() as f64 - sharp;
        if softness == Softness::Some {
            let share = sharp / samples.len() as f64;
            mixture.sharp_share = share.clamp(NO_SHARE, 1.0 - NO_SHARE);
        }
        let blur: f64 = own.iter().map(|o| o.mean).sum();
        mixture.mean_px2 = (blur / soft.max(1e-3)).max(LEAST_MEAN * typical * mixture.noise_scale);
    }
    let finite = mixture.s.iter().all(|s| s.is_finite()) && mixture.log_likelihood.is_finite();
    finite.then_some(mixture)
}

/// Returns the scene's blur at every edge under `mixture`.
pub(super) fn blurs(mixture: &Mixture, samples: &[Sample]) -> Vec<OwnBlur> {
    let mut own = Vec::new();
    own_blurs(mixture, samples, &mut own);
    own
}

/// Densities of the residual of an edge if its error is of one scale, and the scene there sharp or soft.
struct EdgeLikelihood {
    sharp: f64,
    soft: f64,
    /// The scene's blur if it is soft.
    blur: Exponential,
    /// Inverse variance of the error.
    weight: f64,
}

/// Fills `own` with the posterior of the scene's blur of every edge. Returns the log-likelihood.
fn own_blurs(mixture: &Mixture, samples: &[Sample], own: &mut Vec<OwnBlur>) -> f64 {
    own.clear();
    let mut total = 0.0;
    for sample in samples {
        let residual = sample.value - sample.lens(&mixture.s);
        let likelihood = |share: f64, scale: f64| {
            let sigma = sample.sigma * mixture.noise_scale * scale;
            let z = residual / sigma;
            let normal = (-z * z / 2.0).exp() / (sigma * ROOT_TAU);
            let blur = exponential(residual, sigma, mixture.mean_px2);
            EdgeLikelihood {
                sharp: share * mixture.sharp_share * normal,
                soft: share * (1.0 - mixture.sharp_share) * blur.density,
                blur,
                weight: sigma.powi(-2),
            }
        };
        let regular = likelihood(1.0 - OUTLIERS, 1.0);
        let outlier = likelihood(OUTLIERS, OUTLIER_SCALE);
        let density = regular.sharp + regular.soft + outlier.sharp + outlier.soft;
        let density = density.max(1e-300);
        total += density.ln();
        // Moments of the blur, in which a sharp scene counts as zero.
        let (soft, soft_outlier) = (regular.soft / density, outlier.soft / density);
        let mean = soft * regular.blur.mean + soft_outlier * outlier.blur.mean;
        let square = soft * regular.blur.mean_square() + soft_outlier * outlier.blur.mean_square();
        let is_regular = regular.sharp / density + soft;
        own.push(OwnBlur {
            sharp: regular.sharp / density + outlier.sharp / density,
            mean,
            spread: (square - mean * mean).max(0.0),
            weight: is_regular * regular.weight + (1.0 - is_regular) * outlier.weight,
        });
    }
    total
}

const ROOT_TAU: f64 = 2.506_628_274_631_000_5;

/// The sum of a normal error and an exponential blur.
struct Exponential {
    density: f64,
    /// Expected blur and its variance given the sum.
    mean: f64,
    variance: f64,
}

impl Exponential {
    fn mean_square(&self) -> f64 {
        self.mean.powi(2) + self.variance
    }
}

/// Returns the density of error plus blur at `residual`, and the posterior of the blur: a normal distribution cut at zero.
fn exponential(residual: f64, sigma: f64, mean_px2: f64) -> Exponential {
    let centre = residual - sigma * sigma / mean_px2;
    let z = centre / sigma;
    // phi(z) / Phi(z); by its asymptotic series where both vanish.
    let (log_cumulative, ratio) = if z > -4.0 {
        let StandardNormal {
            density,
            cumulative,
        } = StandardNormal::at(z);
        let cumulative = cumulative.max(1e-12);
        (cumulative.ln(), density / cumulative)
    } else {
        let ratio = -z - 1.0 / z + 2.0 / z.powi(3);
        (-z * z / 2.0 - (ratio * ROOT_TAU).ln(), ratio)
    };
    let exponent = (sigma / mean_px2).powi(2) / 2.0 - residual / mean_px2;
    Exponential {
        density: (exponent + log_cumulative).exp() / mean_px2,
        mean: (centre + sigma * ratio).max(0.0),
        variance: (sigma * sigma * (1.0 - ratio * (ratio + z))).max(0.0),
    }
}

/// Returns a first estimate: the expectile of the variances at `START_QUANTILE`, by iteratively reweighted least squares.
fn envelope(samples: &[Sample]) -> Option<Mixture> {
    let targets: Vec<f64> = samples.iter().map(|s| s.value).collect();
    let plain: Vec<f64> = samples.iter().map(|s| s.sigma.powi(-2)).collect();
    let mut s = solve(samples, &targets, &plain)?;
    for _ in 0..30 {
        let weights: Vec<f64> = (samples.iter().zip(&plain))
            .map(|(sample, w)| {
                let residual = sample.value - sample.lens(&s);
                // The weight of an absolute deviation, so that large blur does not pull.
                let size = residual.abs().max(sample.sigma) / sample.sigma;
                let side = if residual > 0.0 {
                    START_QUANTILE
                } else {
                    1.0 - START_QUANTILE
                };
                side * w / size
            })
            .collect();
        s = solve(samples, &targets, &weights)?;
    }
    let mut residuals: Vec<f64> = samples.iter().map(|x| x.value - x.lens(&s)).collect();
    let mean = residuals.iter().sum::<f64>() / residuals.len() as f64;
    let mut sigmas: Vec<f64> = samples.iter().map(|x| x.sigma).collect();
    let typical = median(&mut sigmas);
    let upper = quantile(&mut residuals, 0.8);
    Some(Mixture {
        s,
        sharp_share: 0.4,
        mean_px2: mean.max(upper).max(2.0 * typical),
        noise_scale: 1.0,
        log_likelihood: f64::NEG_INFINITY,
    })
}

/// Solves the weighted normal equations by Cholesky decomposition. `None` if they are singular.
pub(super) fn solve(
    samples: &[Sample],
    targets: &[f64],
    weights: &[f64],
) -> Option<[f64; UNKNOWNS]> {
    let mut normal = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    let mut right = SVector::<f64, UNKNOWNS>::zeros();
    for ((sample, target), weight) in samples.iter().zip(targets).zip(weights) {
        let row = SVector::from(sample.row);
        right += row * (weight * target);
        normal += row * row.transpose() * *weight;
    }
    let largest = normal.diagonal().max();
    let factor = normal.cholesky()?;
    let pivots = factor.l().diagonal();
    let is_regular = pivots.iter().all(|pivot| pivot * pivot > 1e-12 * largest);
    is_regular.then(|| factor.solve(&right).into())
}
