//! The skew-normal PSF of the paper, fitted in the meridional frame (Eqs 36-42 and 46-54, corrected).
//!
//! It is mirror-symmetric about the meridian, like the PSFs of a rotationally symmetric lens
//! (docs/background/model.md section 7).

use super::skew_normal_density::{B, PHI, SKEW_CAP, T_MAX};
use super::{LocalBlur, Mixture, MomentPsf, SkewNormalDensity};
use crate::field::Meridian;
use crate::moments::MeridionalMoments;

/// A skew-normal density skewed along the meridian.
///
/// It matches mu20, mu02, mu11, mu21 and mu03, and mu30 up to a skewness of 0.995, the largest that a skew-normal can
/// have. Its mu12 is zero.
#[derive(Debug, Clone, Copy)]
pub struct SkewNormal;

impl MomentPsf for SkewNormal {
    const ID: &'static str = "skew-normal";

    fn mixture(&self, blur: &LocalBlur) -> Mixture {
        let m = blur.moments.meridional(blur.meridian);
        Mixture::One(meridional_density(&m, blur.meridian))
    }
}

/// Returns the skew e = s / sqrt(mu20) along the meridian that gives the skewness mu30 / mu20^1.5, and whether it
/// was capped at the admissible range.
pub fn meridional_skew(m: &MeridionalMoments) -> (f64, bool) {
    let skewness = m.mu30 / (m.mu20 * m.mu20.sqrt());
    let free = (skewness.abs() / PHI).cbrt();
    let cap = SKEW_CAP * T_MAX.sqrt();
    let e = if skewness == 0.0 {
        0.0
    } else {
        free.min(cap).copysign(skewness)
    };
    (e, free > cap)
}

/// Returns the meridional fit as a density in image axes. Both variances must be positive.
pub fn meridional_density(m: &MeridionalMoments, meridian: Meridian) -> SkewNormalDensity {
    let (e, _) = meridional_skew(m);
    let s = e * m.mu20.sqrt();
    let Meridian { cos, sin } = meridian;
    let covariance = m.covariance(meridian);
    SkewNormalDensity::new(covariance, [s * cos, s * sin])
}

/// A skew-normal density in the parameters of the paper (Eqs 37-42 and 47-54); kappa are inverse scales.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperParameters {
    /// Inverse scale along x, px^-1.
    pub kappa1: f64,
    /// Inverse scale along y, px^-1.
    pub kappa2: f64,
    /// Correlation of the underlying normal.
    pub omega: f64,
    /// Skew along x, in (-1, 1).
    pub delta1: f64,
    /// Skew along y, in (-1, 1).
    pub delta2: f64,
    /// Shape along x.
    pub alpha1: f64,
    /// Shape along y.
    pub alpha2: f64,
}

impl PaperParameters {
    /// Creates the parameters from the covariance (xx, xy, yy) and the skew vector s, like
    /// [`SkewNormalDensity::new`].
    pub fn new(covariance: [f64; 3], s: [f64; 2]) -> Self {
        let [xx, xy, yy] = covariance;
        let kappa1 = 1.0 / (xx + B * B * s[0] * s[0]).sqrt();
        let kappa2 = 1.0 / (yy + B * B * s[1] * s[1]).sqrt();
        let (delta1, delta2) = (kappa1 * s[0], kappa2 * s[1]);
        let omega = (xy + B * B * s[0] * s[1]) * kappa1 * kappa2;
        let plain = 1.0 - omega * omega;
        let skewed = plain - delta1 * delta1 - delta2 * delta2 + 2.0 * delta1 * delta2 * omega;
        let gap = (plain * skewed).sqrt();
        Self {
            kappa1,
            kappa2,
            omega,
            delta1,
            delta2,
            alpha1: (delta1 - delta2 * omega) / gap,
            alpha2: (delta2 - delta1 * omega) / gap,
        }
    }

    /// Returns the density at (`x`, `y`) px from the centroid by Eq 36, corrected: kappa is an inverse scale, and the
    /// offset b delta centres the density.
    pub fn density(&self, x: f64, y: f64) -> f64 {
        let (g1, g2) = (
            self.kappa1 * x + B * self.delta1,
            self.kappa2 * y + B * self.delta2,
        );
        let plain = 1.0 - self.omega * self.omega;
        let quadratic = (g1 * g1 - 2.0 * self.omega * g1 * g2 + g2 * g2) / plain;
        let peak = self.kappa1 * self.kappa2 / (std::f64::consts::PI * plain.sqrt());
        peak * (-0.5 * quadratic).exp() * super::normal_cdf(self.alpha1 * g1 + self.alpha2 * g2)
    }
}
