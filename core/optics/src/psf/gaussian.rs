//! The Gaussian PSF: matches centroid and covariance; always symmetric.

use super::{LocalBlur, Mixture, MomentPsf, SkewNormalDensity};

/// A bivariate normal density with the covariance of the blur; third moments are ignored.
#[derive(Debug, Clone, Copy)]
pub struct Gaussian;

impl MomentPsf for Gaussian {
    const ID: &'static str = "gaussian";

    fn mixture(&self, blur: &LocalBlur) -> Mixture {
        let m = &blur.moments;
        Mixture::One(SkewNormalDensity::new([m.mu20, m.mu11, m.mu02], [0.0, 0.0]))
    }
}
