//! Initial estimates of the five reduced numbers of one channel from S1..S10 of its distances.
//!
//! Variances do not tell on which side of focus a distance lies, nor how much of the blur is spherical aberration. So all
//! choices of sign are starts, over a grid of shares of spherical aberration; the profiles of edges then decide.

use crate::fit::initial::InitialEstimate;
use seidel_optics::lens::{MomentCoefficients, VergencePoint, VergenceSeries};

/// Least variance of the blur on the axis that is taken for rays, px².
const LEAST_VARIANCE: f64 = 0.02;
/// Angles of the grid: the sine is the root of the share of spherical aberration in the variance on the axis, degrees.
const SHARES: [f64; 8] = [-75.0, -45.0, -20.0, -5.0, 5.0, 20.0, 45.0, 75.0];

/// Returns initial estimates from S1..S10 at each vergence (1/m), which rise. `blur` is the variance of the symmetric blur.
pub(super) fn estimates(planes: &[(f64, MomentCoefficients)], blur: f64) -> Vec<InitialEstimate> {
    let variances: Vec<f64> = (planes.iter())
        .map(|(_, s)| (s.0[0] - blur).max(LEAST_VARIANCE))
        .collect();
    let least = variances.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = |k: usize| planes.iter().map(|(_, s)| s.0[k]).sum::<f64>() / planes.len() as f64;
    let size = variances.iter().copied().fold(0.0, f64::max).sqrt();
    let limit = |v: f64| v.clamp(0.1 * size, 4.0 * size);
    let sagittal = limit(2.0 * mean(4).max(0.0).sqrt());
    let meridional = limit(2.0 * (mean(3) + mean(4)).max(0.0).sqrt());
    let mut pairs = vec![(0.0, 0.0)];
    for delta in [sagittal, -sagittal] {
        for both in [meridional, -meridional] {
            pairs.push((both - delta, delta));
        }
    }
    // The third moment near the axis at the widest blur.
    let widest = (0..planes.len())
        .max_by(|a, b| variances[*a].total_cmp(&variances[*b]))
        .unwrap_or(0);
    let mut all = Vec::new();
    for degrees in SHARES {
        let beta = (72.0 * least).sqrt() * degrees.to_radians().sin();
        for crossing in 0..=planes.len() {
            let points: Vec<VergencePoint> = (planes.iter().zip(&variances).enumerate())
                .map(|(k, ((vergence, _), variance))| {
                    let side = if k < crossing { -1.0 } else { 1.0 };
                    let half = (variance - beta * beta / 72.0).max(0.0).sqrt();
                    VergencePoint {
                        vergence_per_m: *vergence,
                        value: 2.0 * (side * half - beta / 3.0),
                        sigma: 0.0,
                    }
                })
                .collect();
            let alpha = if points.len() > 1 {
                let line = VergenceSeries::fit_line(&points);
                [line.coefficients[0], line.coefficients[1]]
            } else {
                [points[0].value, 0.0]
            };
            let a = points[widest].value;
            let per_phi = a * a / 6.0 + 7.0 * a * beta / 24.0 + beta * beta / 8.0;
            let phi = -planes[widest].1.0[9] / per_phi.max(0.05);
            for &(gamma, delta) in &pairs {
                all.push(InitialEstimate {
                    alpha,
                    beta,
                    gamma,
                    delta,
                    phi: phi.clamp(-2.0 * size, 2.0 * size),
                    misfit: f64::INFINITY,
                });
            }
        }
    }
    all
}
