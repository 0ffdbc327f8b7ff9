//! Bivariate skew-normal densities and means of two, the form of all PSFs built from moments.

use super::normal::{normal_cdf, sample_rows_f32};
use super::{KernelBounds, SampleGrid};

/// sqrt(2 / pi): the mean of a half-normal variable.
pub const B: f64 = 0.797_884_560_802_865_4;
/// b (4 / pi - 1): third central moment per cubed skew component (docs/background/model.md section 7).
pub const PHI: f64 = 0.218_013_614_144_990_15;
/// 1 / (1 - 2 / pi): supremum of s' Sigma^-1 s.
pub const T_MAX: f64 = 2.751_938_393_884_109;
/// Largest used share of the admissible skew; below one, so that the density stays finite.
pub const SKEW_CAP: f64 = 0.999;

/// Half size of a kernel in standard deviations of the underlying normal: 6e-7 of the light lies outside.
const REACH_SIGMAS: f64 = 5.0;

/// Smallest variance of the normal part of a density whose samples sum to one, along its narrowest direction, px².
///
/// By Poisson summation, the sum is off by the spectrum of the density at whole frequencies: each less than
/// exp(-2 pi² v) for variance v, 3e-9 for one.
const RESOLVED_VARIANCE_PX2: f64 = 1.0;

/// A bivariate skew-normal density with zero mean, covariance Sigma and third central moments PHI s_i s_j s_k
/// (Eqs 36-42, without reference to axes).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkewNormalDensity {
    /// Offset b s of the centroid from the mean of the underlying normal, px.
    pub offset: [f64; 2],
    /// Inverse of Psi = Sigma + b² s s': xx, xy, yy, px^-2.
    pub inverse: [f64; 3],
    /// eta: gradient of the argument of the normal distribution function, px^-1.
    pub eta: [f64; 2],
    /// Diagonal of Psi, px².
    pub spread: [f64; 2],
    /// 1 / (pi sqrt(det Psi)), px^-2.
    pub peak: f64,
}

impl SkewNormalDensity {
    /// Creates the density from the covariance (xx, xy, yy; px²) and the skew vector s (px).
    ///
    /// The covariance must be positive definite, and s' Sigma^-1 s must be below [`T_MAX`].
    pub fn new(covariance: [f64; 3], s: [f64; 2]) -> Self {
        let [xx, xy, yy] = covariance;
        let psi = [
            xx + B * B * s[0] * s[0],
            xy + B * B * s[0] * s[1],
            yy + B * B * s[1] * s[1],
        ];
        let determinant = psi[0] * psi[2] - psi[1] * psi[1];
        let inverse = [
            psi[2] / determinant,
            -psi[1] / determinant,
            psi[0] / determinant,
        ];
        let u = [
            inverse[0] * s[0] + inverse[1] * s[1],
            inverse[1] * s[0] + inverse[2] * s[1],
        ];
        let gap = (1.0 - (u[0] * s[0] + u[1] * s[1]))
            .max(f64::MIN_POSITIVE)
            .sqrt();
        Self {
            offset: [B * s[0], B * s[1]],
            inverse,
            eta: [u[0] / gap, u[1] / gap],
            spread: [psi[0], psi[2]],
            peak: 1.0 / (std::f64::consts::PI * determinant.sqrt()),
        }
    }

    /// Returns the density at (`x`, `y`) px from the centroid, in light per px².
    pub fn density(&self, x: f64, y: f64) -> f64 {
        let (z1, z2) = (x + self.offset[0], y + self.offset[1]);
        let [a, b, c] = self.inverse;
        let quadratic = a * z1 * z1 + 2.0 * b * z1 * z2 + c * z2 * z2;
        let cdf = if self.eta == [0.0, 0.0] {
            0.5
        } else {
            normal_cdf(self.eta[0] * z1 + self.eta[1] * z2)
        };
        self.peak * (-0.5 * quadratic).exp() * cdf
    }

    /// Returns the density stretched along x by `factor`.
    #[must_use]
    pub fn stretched_x(&self, factor: f64) -> Self {
        let [xx, xy, yy] = self.inverse;
        Self {
            offset: [self.offset[0] * factor, self.offset[1]],
            inverse: [xx / (factor * factor), xy / factor, yy],
            eta: [self.eta[0] / factor, self.eta[1]],
            spread: [self.spread[0] * factor * factor, self.spread[1]],
            peak: self.peak / factor,
        }
    }

    /// Returns the box about the centroid that holds all but a negligible part of the light.
    pub fn bounds(&self) -> KernelBounds {
        let (sx, sy) = (
            REACH_SIGMAS * self.spread[0].sqrt(),
            REACH_SIGMAS * self.spread[1].sqrt(),
        );
        KernelBounds {
            left_px: sx + self.offset[0],
            right_px: sx - self.offset[0],
            up_px: sy + self.offset[1],
            down_px: sy - self.offset[1],
        }
    }
}

impl SkewNormalDensity {
    /// Returns the variance of the normal part along its narrowest direction, px².
    ///
    /// The density is a half-normal along s convolved with a normal of covariance Psi - s s', which limits how sharp
    /// the density is.
    fn normal_part_variance(&self) -> f64 {
        let root = 1.0 / (std::f64::consts::PI * self.peak);
        let s = [self.offset[0] / B, self.offset[1] / B];
        let xx = self.spread[0] - s[0] * s[0];
        let xy = -self.inverse[1] * root * root - s[0] * s[1];
        let yy = self.spread[1] - s[1] * s[1];
        0.5 * (xx + yy - (xx - yy).hypot(2.0 * xy))
    }
}

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
