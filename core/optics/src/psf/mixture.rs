//! Means of two skew-normal densities, the form of all PSFs built from moments.

use super::skew_normal_samples::sample_rows_f32;
use super::{KernelBounds, SampleGrid, SkewNormalDensity};

/// Smallest variance of the normal part of a density whose samples sum to one, along its narrowest direction, px².
///
/// By Poisson summation, the sum is off by the spectrum of the density at whole frequencies: each less than
/// exp(-2 pi² v) for variance v, 3e-9 for one.
const RESOLVED_VARIANCE_PX2: f64 = 1.0;

/// One skew-normal density, or the mean of two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mixture {
    /// A single density.
    One(SkewNormalDensity),
    /// The mean of two.
    Two([SkewNormalDensity; 2]),
}

impl Mixture {
    /// Returns the densities of which this is the mean.
    pub fn parts(&self) -> &[SkewNormalDensity] {
        match self {
            Self::One(density) => std::slice::from_ref(density),
            Self::Two(pair) => pair,
        }
    }

    /// Returns the density stretched along x by `factor`.
    #[must_use]
    pub fn stretched_x(&self, factor: f64) -> Self {
        match self {
            Self::One(density) => Self::One(density.stretched_x(factor)),
            Self::Two(pair) => Self::Two(pair.map(|density| density.stretched_x(factor))),
        }
    }

    /// Returns the density at (`x`, `y`) px from the centroid, in light per px².
    pub fn density(&self, x: f64, y: f64) -> f64 {
        let parts = self.parts();
        parts.iter().map(|p| p.density(x, y)).sum::<f64>() / parts.len() as f64
    }

    /// Returns the box about the centroid that holds all but a negligible part of the light.
    pub fn bounds(&self) -> KernelBounds {
        let mut parts = self.parts().iter().map(SkewNormalDensity::bounds);
        let first = parts.next().expect("a mixture has at least one part");
        parts.fold(first, |a, b| KernelBounds {
            left_px: a.left_px.max(b.left_px),
            right_px: a.right_px.max(b.right_px),
            up_px: a.up_px.max(b.up_px),
            down_px: a.down_px.max(b.down_px),
        })
    }

    /// Returns whether samples on any grid of unit spacing sum to one within 1e-6.
    pub fn sums_to_one(&self) -> bool {
        let mut parts = self.parts().iter();
        parts.all(|part| part.normal_part_variance() >= RESOLVED_VARIANCE_PX2)
    }

    /// Samples the density at the pixel centres of `grid` into `out`, row-major.
    ///
    /// # Panics
    /// If the length of `out` is not the number of pixels of `grid`.
    pub fn sample(&self, grid: &SampleGrid, out: &mut [f64]) {
        assert_eq!(out.len(), grid.len(), "one sample a pixel");
        for (row, line) in out.chunks_exact_mut(grid.width).enumerate() {
            let y = grid.first_y_px + row as f64;
            for (column, sample) in line.iter_mut().enumerate() {
                *sample = self.density(grid.first_x_px + column as f64, y);
            }
        }
    }

    /// Samples like [`Mixture::sample`] in single precision, with SIMD code.
    ///
    /// # Panics
    /// If the length of `out` is not the number of pixels of `grid`.
    pub fn sample_f32(&self, grid: &SampleGrid, out: &mut [f32]) {
        assert_eq!(out.len(), grid.len(), "one sample a pixel");
        out.fill(0.0);
        let parts = self.parts();
        for part in parts {
            sample_rows_f32(part, 1.0 / parts.len() as f64, grid, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the largest deviation of the sum of samples from one, over many grid phases.
    fn sum_error(mixture: &Mixture) -> f64 {
        let phases = [0.0, 0.13, 0.25, 0.41, 0.5, 0.77];
        let errors = phases.iter().flat_map(|x| phases.map(|y| (*x, y)));
        errors.fold(0.0, |worst, (x, y)| {
            let window = SampleGrid::for_tile(121, 121, 60.0 + x, 60.0 + y);
            let mut samples = vec![0.0; window.len()];
            mixture.sample(&window, &mut samples);
            f64::max(worst, (samples.iter().sum::<f64>() - 1.0).abs())
        })
    }

    #[test]
    fn resolved_densities_sum_to_one() {
        let one = |covariance, s| Mixture::One(SkewNormalDensity::new(covariance, s));
        let blunt = SkewNormalDensity::new([20.0, 6.0, 12.0], [5.0, -1.0]);
        for resolved in [
            one([1.0, 0.0, 1.0], [0.0, 0.0]),
            one([20.0, 6.0, 12.0], [0.0, 0.0]),
            Mixture::One(blunt),
            Mixture::Two([blunt, SkewNormalDensity::new([9.0, -4.0, 5.0], [0.5, 1.5])]),
        ] {
            assert!(resolved.sums_to_one(), "{resolved:?}");
            assert!(sum_error(&resolved) < 1e-6, "{resolved:?}");
        }
        // Narrow, and wide but sharp on one side.
        let sharp = SkewNormalDensity::new([20.0, 0.0, 12.0], [7.4, 0.0]);
        for unresolved in [
            one([0.2, 0.0, 4.0], [0.0, 0.0]),
            Mixture::One(sharp),
            Mixture::Two([blunt, sharp]),
        ] {
            assert!(!unresolved.sums_to_one(), "{unresolved:?}");
            assert!(sum_error(&unresolved) > 1e-6, "{unresolved:?}");
        }
    }
}
