//! The mirrored pair: the mean of two skew-normals mirrored in the meridian. It carries mu12, which a
//! single skew-normal cannot without breaking the symmetry (model.md section 7).

use super::mixture::{PHI, SKEW_CAP, T_MAX};
use super::{LocalBlur, Mixture, MomentPsf, SkewNormalDensity};
use crate::field::Meridian;

/// Matches all seven moments where mu12 / mu30 is not negative and the skew is admissible. Otherwise
/// mu12 of the wrong sign is dropped, and a skew too large is shortened along its direction.
#[derive(Debug, Clone, Copy)]
pub struct MirroredPair;

impl MomentPsf for MirroredPair {
    const ID: &'static str = "mirrored-pair";

    fn mixture(&self, blur: &LocalBlur) -> Mixture {
        let m = blur.moments.meridional(blur.meridian);
        let mut along = (m.mu30 / PHI).cbrt();
        let mut across = if m.mu30 * m.mu12 > 0.0 {
            (m.mu12 / (PHI * along)).sqrt()
        } else {
            0.0
        };
        let size = along * along / m.mu20 + across * across / m.mu02;
        let largest = SKEW_CAP * SKEW_CAP * T_MAX;
        if size > largest {
            let shorter = (largest / size).sqrt();
            along *= shorter;
            across *= shorter;
        }
        let Meridian { cos, sin } = blur.meridian;
        let covariance = [
            m.mu20 * cos * cos + m.mu02 * sin * sin,
            (m.mu20 - m.mu02) * cos * sin,
            m.mu20 * sin * sin + m.mu02 * cos * cos,
        ];
        let half = |t: f64| {
            SkewNormalDensity::new(covariance, [along * cos - t * sin, along * sin + t * cos])
        };
        if across == 0.0 {
            Mixture::One(half(0.0))
        } else {
            Mixture::Two([half(across), half(-across)])
        }
    }
}
