//! What every moment-built PSF is: the mean of one or two bivariate skew-normal densities.

use super::normal::{normal_cdf, sample_rows_f32};
use super::{KernelBounds, SampleGrid};

/// sqrt(2 / pi): the mean of a half-normal variable.
pub const B: f64 = 0.797_884_560_802_865_4;
/// b (4 / pi - 1): third central moment per cubed skew component (docs/background/model.md section 7).
pub const PHI: f64 = 0.218_013_614_144_990_15;
/// 1 / (1 - 2 / pi): supremum of s' Sigma^-1 s.
pub const T_MAX: f64 = 2.751_938_393_884_109;
/// How much of the admissible skew is used at most, so that the density stays finite.
pub const SKEW_CAP: f64 = 0.999;

/// How many standard deviations of the underlying normal a kernel reaches: 6e-7 of its light is beyond.
const REACH_SIGMAS: f64 = 5.0;

/// Least variance along any direction of the normal part of a density whose samples at pixels sum to
/// one. By Poisson's summation the sum is off by the density's spectrum at whole frequencies: less
/// than exp(-2 pi² v) each for variance v, 3e-9 for one.
const RESOLVED_VARIANCE_PX2: f64 = 1.0;

/// A bivariate skew-normal density with zero mean, covariance Sigma and third central moments
/// PHI s_i s_j s_k (Eqs 36-42 in frame-free form).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkewNormalDensity {
    /// Offset b s of the centroid from the centre of the underlying normal, px.
    pub offset: [f64; 2],
    /// Inverse of Psi = Sigma + b² s s': xx, xy, yy, px^-2.
    pub inverse: [f64; 3],
    /// eta: the argument of the normal distribution function per px of offset.
    pub eta: [f64; 2],
    /// Psi's diagonal, px².
    pub spread: [f64; 2],
    /// 1 / (pi sqrt(det Psi)), px^-2.
    pub peak: f64,
}

impl SkewNormalDensity {
    /// From the covariance (xx, xy, yy; px²), which must be positive definite, and the skew vector s
    /// (px), which must satisfy s' Sigma^-1 s < [`T_MAX`].
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

    /// Light per px² at (`x`, `y`) px from the centroid.
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

    /// The same density stretched along x by `factor`.
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

    /// The box about the centroid that holds all but a negligible part of the light.
    pub fn reach(&self) -> KernelBounds {
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
    /// Variance along the narrowest direction of the normal with which a half-normal along s is
    /// convolved to give this density: its covariance is Psi - s s'. It governs how sharp the density is.
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
    /// The densities of which this is the mean.
    pub fn parts(&self) -> &[SkewNormalDensity] {
        match self {
            Self::One(density) => std::slice::from_ref(density),
            Self::Two(pair) => pair,
        }
    }

    /// The same density stretched along x by `factor`.
    #[must_use]
    pub fn stretched_x(&self, factor: f64) -> Self {
        match self {
            Self::One(density) => Self::One(density.stretched_x(factor)),
            Self::Two(pair) => Self::Two(pair.map(|density| density.stretched_x(factor))),
        }
    }

    /// Light per px² at (`x`, `y`) px from the centroid.
    pub fn density(&self, x: f64, y: f64) -> f64 {
        let parts = self.parts();
        parts.iter().map(|p| p.density(x, y)).sum::<f64>() / parts.len() as f64
    }

    /// The box about the centroid that holds all but a negligible part of the light.
    pub fn reach(&self) -> KernelBounds {
        let mut parts = self.parts().iter().map(SkewNormalDensity::reach);
        let first = parts.next().expect("a mixture has at least one part");
        parts.fold(first, |a, b| KernelBounds {
            left_px: a.left_px.max(b.left_px),
            right_px: a.right_px.max(b.right_px),
            up_px: a.up_px.max(b.up_px),
            down_px: a.down_px.max(b.down_px),
        })
    }

    /// Whether samples on any grid of unit spacing sum to one within 1e-6.
    pub fn sums_to_one(&self) -> bool {
        let mut parts = self.parts().iter();
        parts.all(|part| part.normal_part_variance() >= RESOLVED_VARIANCE_PX2)
    }

    /// Samples the density at the pixel centres of `window`.
    ///
    /// # Panics
    /// If `out` is not as long as the window has pixels.
    pub fn sample(&self, window: &SampleGrid, out: &mut [f64]) {
        assert_eq!(out.len(), window.len(), "one sample a pixel");
        for (row, line) in out.chunks_exact_mut(window.width).enumerate() {
            let y = window.first_y_px + row as f64;
            for (column, sample) in line.iter_mut().enumerate() {
                *sample = self.density(window.first_x_px + column as f64, y);
            }
        }
    }

    /// As [`Mixture::sample`] in single precision, by vector code.
    ///
    /// # Panics
    /// If `out` is not as long as the window has pixels.
    pub fn sample_f32(&self, window: &SampleGrid, out: &mut [f32]) {
        assert_eq!(out.len(), window.len(), "one sample a pixel");
        out.fill(0.0);
        let parts = self.parts();
        for part in parts {
            sample_rows_f32(part, 1.0 / parts.len() as f64, window, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The worst sum over grids of many phases, less one.
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
