//! How far a plate's samples are to be gone by.

use super::sums::Typical;

/// The noise of a plane and what else a picture cannot be told by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trust {
    /// Variances of the noise, and with what is inexact in typical light.
    noise: f64,
    typical: f64,
    /// The same of samples that are not brighter than most.
    most: f64,
    /// How exactly operators and lenses are known, as a share of the light: it counts as noise.
    inexact: f64,
}

impl Trust {
    /// Of a plane with noise of a standard deviation.
    pub(super) fn new(blurred: &[f32], noise: f64, inexact: f64) -> Self {
        let light = Typical::of(blurred.iter().map(|v| v.abs()).collect());
        let with = |light: f64| noise * noise + (inexact * light).powi(2);
        Self {
            noise: noise * noise,
            // Any number will do for what is dark all over.
            typical: with(light.root_mean_square).max(f64::MIN_POSITIVE.sqrt()),
            most: with(light.most),
            inexact,
        }
    }

    /// Standard deviation of what is not known of a typical sample.
    pub(super) fn deviation(&self) -> f64 {
        self.typical.sqrt()
    }

    /// How much a sample counts, from 0 to 1: less where it is brighter than most.
    pub(super) fn weight(&self, sample: f32) -> f32 {
        let variance = self.noise + (self.inexact * f64::from(sample)).powi(2);
        if variance <= self.most {
            return 1.0;
        }
        (self.most / variance) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_brighter_than_most_count_less() {
        let mut plane = vec![0.2; 1000];
        plane[3] = 1e4;
        let trust = Trust::new(&plane, 0.001, 2e-3);
        assert!((trust.deviation() - 0.001_f64.hypot(2e-3 * 0.2)).abs() < 1e-6);
        assert_eq!(trust.weight(0.2), 1.0);
        assert!(trust.weight(1e4) < 1e-6);
    }

    #[test]
    fn dark_planes_without_noise_have_a_deviation() {
        assert!(Trust::new(&[0.0; 10], 0.0, 2e-3).deviation() > 0.0);
    }
}
