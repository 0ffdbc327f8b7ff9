//! Photon transfer: counts per electron from how the noise grows with the signal.
//!
//! The variance of a pixel is sigma² + gain x signal. Squared residuals of fitted lights also hold the error of the fitted
//! shape, which grows with the square of a light's peak; the two are separated by robust regression over many lights of
//! different brightness.

/// A pixel of a fitted light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Fitted signal, counts.
    pub signal: f64,
    /// Largest signal of the light, counts.
    pub peak: f64,
    /// Squared residual, corrected for the freedom of the fit.
    pub square: f64,
    /// Variance of a dark pixel, counts².
    pub dark_variance: f64,
}

/// Counts per electron, with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Counts per electron.
    pub counts_per_electron: f64,
    /// Standard deviation.
    pub sigma: f64,
}

/// Pixels that an estimate needs.
const MIN_PIXELS: usize = 300;
/// Largest relative standard deviation of an estimate that is reported.
const MAX_RELATIVE_SIGMA: f64 = 0.25;
const ITERATIONS: usize = 20;
/// Squared residuals above this multiple of their expectation are left out, and the mean of the rest relative to all: for
/// a normal distribution clipped at 3 standard deviations.
const CLIP: f64 = 9.0;
const CLIPPED_MEAN: f64 = 0.9733;

/// Estimates the gain; `None` where the residuals do not determine it.
pub fn estimate(residuals: &[Residual]) -> Option<Gain> {
    if residuals.len() < MIN_PIXELS {
        return None;
    }
    // Unknown shares of signal and of squared peak.
    let mut shares = [0.0, 0.0];
    let first: f64 = residuals
        .iter()
        .map(|r| (r.square - r.dark_variance).max(0.0))
        .sum();
    let light: f64 = residuals.iter().map(|r| r.signal.max(0.0)).sum();
    shares[0] = first / light.max(f64::MIN_POSITIVE);
    let mut gain = None;
    for _ in 0..ITERATIONS {
        let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
        let mut right = [0.0, 0.0];
        for r in residuals {
            let regressors = [r.signal.max(0.0), r.peak * r.peak];
            let expected = r.dark_variance + shares[0] * regressors[0] + shares[1] * regressors[1];
            if r.square > CLIP * expected {
                continue;
            }
            // A squared normal deviate has a standard deviation in proportion to its mean.
            let weight = 1.0 / (expected * expected);
            let excess = r.square / CLIPPED_MEAN - r.dark_variance;
            a += weight * regressors[0] * regressors[0];
            b += weight * regressors[0] * regressors[1];
            c += weight * regressors[1] * regressors[1];
            right[0] += weight * regressors[0] * excess;
            right[1] += weight * regressors[1] * excess;
        }
        let determinant = a * c - b * b;
        if !(a > 0.0 && determinant > 1e-12 * a * c) {
            return None;
        }
        let both = [
            (right[0] * c - right[1] * b) / determinant,
            (right[1] * a - right[0] * b) / determinant,
        ];
        // The shape error cannot be negative.
        let (next, variance) = if both[1] >= 0.0 {
            (both, 2.0 * c / determinant)
        } else {
            ([right[0] / a, 0.0], 2.0 / a)
        };
        let change = (next[0] - shares[0]).abs();
        shares = next.map(|v| v.max(0.0));
        gain = Some(Gain {
            counts_per_electron: next[0],
            sigma: variance.sqrt(),
        });
        if change < 1e-6 * shares[0].abs() {
            break;
        }
    }
    gain.filter(|g| {
        g.counts_per_electron > 0.0 && g.sigma < MAX_RELATIVE_SIGMA * g.counts_per_electron
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    #[test]
    fn the_gain_is_found_beside_errors_of_the_shape() {
        let mut random = SplitMix64::new(4);
        let mut normal = || {
            let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
            radius * (std::f64::consts::TAU * random.unit()).cos()
        };
        let mut residuals = Vec::new();
        for light in 0..40 {
            let peak = 300.0 + 200.0 * f64::from(light);
            for pixel in 0..80 {
                let signal = peak * (-f64::from(pixel) / 20.0).exp();
                let variance: f64 = 9.0 + 0.6 * signal + (0.005 * peak).powi(2);
                residuals.push(Residual {
                    signal,
                    peak,
                    square: variance * normal().powi(2),
                    dark_variance: 9.0,
                });
            }
        }
        let gain = estimate(&residuals).expect("determined");
        let error = gain.counts_per_electron - 0.6;
        assert!(
            error.abs() < 3.0 * gain.sigma && gain.sigma < 0.05,
            "{gain:?}"
        );
        assert!(estimate(&residuals[..100]).is_none());
    }
}
