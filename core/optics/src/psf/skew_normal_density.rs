//! The bivariate skew-normal density.

use super::KernelBounds;
use crate::numeric::normal_cdf;

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

    /// Returns the variance of the normal part along its narrowest direction, px².
    ///
    /// The density is a half-normal along s convolved with a normal of covariance Psi - s s', which limits how sharp
    /// the density is.
    pub(super) fn normal_part_variance(&self) -> f64 {
        let root = 1.0 / (std::f64::consts::PI * self.peak);
        let s = [self.offset[0] / B, self.offset[1] / B];
        let xx = self.spread[0] - s[0] * s[0];
        let xy = -self.inverse[1] * root * root - s[0] * s[1];
        let yy = self.spread[1] - s[1] * s[1];
        0.5 * (xx + yy - (xx - yy).hypot(2.0 * xy))
    }
}
