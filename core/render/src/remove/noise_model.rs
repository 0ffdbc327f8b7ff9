//! Weights of a plate's samples from the variance of their noise and of the model error.

use super::winsorised::WinsorisedStatistics;
use rayon::prelude::*;

/// The variance of each sample: noise, and errors of lens and operator, which are proportional to the light.
///
/// The variance of a sample b is s² + (e b)², with s the standard deviation of the noise and e the relative model error.
#[derive(Debug, Clone, Copy)]
pub(super) struct NoiseModel {
    /// s².
    noise_variance: f64,
    /// Variance at the root mean square of the plate's light.
    typical_variance: f64,
    /// Variance at the 99th percentile of the plate's light, up to which samples have full weight.
    full_weight_variance: f64,
    /// e.
    model_error: f64,
}

impl NoiseModel {
    /// Models the samples of `plate`, whose noise has the standard deviation `noise`.
    pub(super) fn new(plate: &[f32], noise: f64, model_error: f64) -> Self {
        let light = WinsorisedStatistics::of_absolute(plate);
        let variance = |light: f64| noise * noise + (model_error * light).powi(2);
        Self {
            noise_variance: noise * noise,
            // A black plate without noise has no scale: any positive value serves.
            typical_variance: variance(light.root_mean_square).max(f64::MIN_POSITIVE.sqrt()),
            full_weight_variance: variance(light.percentile_99),
            model_error,
        }
    }

    /// Standard deviation of a typical sample, noise and model error together.
    pub(super) fn deviation(&self) -> f64 {
        self.typical_variance.sqrt()
    }

    /// Returns W: the weight of each sample of `plate`, 0 where it is not `known`. Each sample has a further error of the
    /// standard deviation in `errors`.
    pub(super) fn weights(&self, plate: &[f32], errors: &[f32], known: &[bool]) -> Vec<f32> {
        let samples = plate.par_iter().zip(errors).zip(known);
        samples
            .map(|((sample, error), known)| {
                if *known {
                    self.weight(*sample, *error)
                } else {
                    0.0
                }
            })
            .collect()
    }

    /// Returns the weight of a sample, from 0 to 1: less than 1 above the 99th percentile of the light.
    fn weight(&self, sample: f32, error: f32) -> f32 {
        let variance = self.noise_variance
            + (self.model_error * f64::from(sample)).powi(2)
            + f64::from(error).powi(2);
        if variance <= self.full_weight_variance {
            return 1.0;
        }
        (self.full_weight_variance / variance) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bright_lights_have_small_weights() {
        let mut plane = vec![0.2; 1000];
        plane[3] = 1e4;
        let model = NoiseModel::new(&plane, 0.001, 2e-3);
        assert!((model.deviation() - 0.001_f64.hypot(2e-3 * 0.2)).abs() < 1e-6);
        assert_eq!(model.weight(0.2, 0.0), 1.0);
        assert!(model.weight(1e4, 0.0) < 1e-6);
    }

    #[test]
    fn black_planes_without_noise_have_a_positive_deviation() {
        assert!(NoiseModel::new(&[0.0; 10], 0.0, 2e-3).deviation() > 0.0);
    }
}
