//! Moments in the meridional frame, where a rotationally symmetric lens has four nonzero ones up to third order.

use super::CentralMoments;
use crate::field::Meridian;

/// The central moments with x along the meridional (radial) and y along the sagittal direction.
///
/// The other three of second and third order are zero by mirror symmetry.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeridionalMoments {
    /// Meridional variance, px².
    pub mu20: f64,
    /// Sagittal variance, px².
    pub mu02: f64,
    /// Mean of r³, px³.
    pub mu30: f64,
    /// Mean of r t², px³.
    pub mu12: f64,
}

impl CentralMoments {
    /// Returns the part that is mirror-symmetric about `meridian`, in meridional axes.
    ///
    /// Drops mu11, mu21 and mu03, which are zero there for a rotationally symmetric lens.
    pub fn meridional(&self, meridian: Meridian) -> MeridionalMoments {
        let m = self.rotated_into(meridian);
        MeridionalMoments {
            mu20: m.mu20,
            mu02: m.mu02,
            mu30: m.mu30,
            mu12: m.mu12,
        }
    }
}

impl MeridionalMoments {
    /// Returns the moments in image axes, with the meridian along `meridian`.
    pub fn in_image(&self, meridian: Meridian) -> CentralMoments {
        CentralMoments {
            mu20: self.mu20,
            mu02: self.mu02,
            mu30: self.mu30,
            mu12: self.mu12,
            ..CentralMoments::default()
        }
        .rotated_into(meridian.inverse())
    }

    /// Returns the covariance (xx, xy, yy; px²) in image axes, with the meridian along `meridian`.
    pub fn covariance(&self, meridian: Meridian) -> [f64; 3] {
        let Meridian { cos, sin } = meridian;
        [
            self.mu20 * cos * cos + self.mu02 * sin * sin,
            (self.mu20 - self.mu02) * cos * sin,
            self.mu20 * sin * sin + self.mu02 * cos * cos,
        ]
    }
}
