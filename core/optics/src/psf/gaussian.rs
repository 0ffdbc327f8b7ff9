//! The Gaussian PSF: right in position, size and elongation, symmetric by nature.

use super::{LocalBlur, Mixture, MomentPsf, SkewNormalDensity};

/// A bivariate normal density with the covariance of the moments; third moments are dropped.
#[derive(Debug, Clone, Copy)]
pub struct Gaussian;

impl MomentPsf for Gaussian {
    const ID: &'static str = "gaussian";

    fn mixture(&self, blur: &LocalBlur) -> Mixture {
        let m = &blur.moments;
        Mixture::One(SkewNormalDensity::new([m.mu20, m.mu11, m.mu02], [0.0, 0.0]))
    }
}
