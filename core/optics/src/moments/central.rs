//! Second and third central moments in image axes.

use crate::field::Meridian;

/// The second (px²) and third (px³) central moments; `mu_pq` is the mean of x^p y^q about the centroid.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CentralMoments {
    /// Mean of x², px².
    pub mu20: f64,
    /// Mean of x y, px².
    pub mu11: f64,
    /// Mean of y², px².
    pub mu02: f64,
    /// Mean of x³, px³.
    pub mu30: f64,
    /// Mean of x² y, px³.
    pub mu21: f64,
    /// Mean of x y², px³.
    pub mu12: f64,
    /// Mean of y³, px³.
    pub mu03: f64,
}

impl CentralMoments {
    /// Names of the moments, in the order of [`CentralMoments::to_array`].
    pub const NAMES: [&'static str; 7] = ["mu20", "mu11", "mu02", "mu30", "mu21", "mu12", "mu03"];

    /// Returns the moments in the order of the paper: mu20, mu11, mu02, mu30, mu21, mu12, mu03.
    pub fn to_array(self) -> [f64; 7] {
        [
            self.mu20, self.mu11, self.mu02, self.mu30, self.mu21, self.mu12, self.mu03,
        ]
    }

    /// Creates the moments from the order of [`CentralMoments::to_array`].
    pub fn from_array([mu20, mu11, mu02, mu30, mu21, mu12, mu03]: [f64; 7]) -> Self {
        Self {
            mu20,
            mu11,
            mu02,
            mu30,
            mu21,
            mu12,
            mu03,
        }
    }

    /// Returns the trace of the covariance, mu20 + mu02, px²: the squared size of the PSF.
    pub fn trace(&self) -> f64 {
        self.mu20 + self.mu02
    }

    /// Returns the smaller eigenvalue of the covariance, px²; negative if no density has these moments.
    pub fn least_variance(&self) -> f64 {
        let half_difference = (self.mu20 - self.mu02) / 2.0;
        self.trace() / 2.0 - half_difference.hypot(self.mu11)
    }

    /// Returns the moments with the eigenvalues of the covariance raised to at least `floor_px2`; eigenvectors and
    /// third moments stay.
    #[must_use]
    pub fn with_least_variance(&self, floor_px2: f64) -> Self {
        if self.least_variance() >= floor_px2 {
            return *self;
        }
        // Eigenvalues are mean +- radius, along half the angle of (half_difference, mu11).
        let half_difference = (self.mu20 - self.mu02) / 2.0;
        let radius = half_difference.hypot(self.mu11);
        let mean = self.trace() / 2.0;
        let (large, small) = (
            (mean + radius).max(floor_px2),
            (mean - radius).max(floor_px2),
        );
        let (cos2, sin2) = if radius > 0.0 {
            (half_difference / radius, self.mu11 / radius)
        } else {
            (1.0, 0.0)
        };
        let (mean, radius) = ((large + small) / 2.0, (large - small) / 2.0);
        Self {
            mu20: mean + radius * cos2,
            mu11: radius * sin2,
            mu02: mean - radius * cos2,
            ..*self
        }
    }

    /// Returns the moments in rotated axes: the new x axis lies along `meridian`, the new y axis 90° further.
    #[must_use]
    pub fn rotated_into(&self, meridian: Meridian) -> Self {
        let Meridian { cos: c, sin: s } = meridian;
        let Self {
            mu20,
            mu11,
            mu02,
            mu30,
            mu21,
            mu12,
            mu03,
        } = *self;
        Self {
            mu20: mu20 * c * c + 2.0 * mu11 * c * s + mu02 * s * s,
            mu11: (mu02 - mu20) * c * s + mu11 * (c * c - s * s),
            mu02: mu20 * s * s - 2.0 * mu11 * c * s + mu02 * c * c,
            mu30: mu30 * c * c * c
                + 3.0 * mu21 * c * c * s
                + 3.0 * mu12 * c * s * s
                + mu03 * s * s * s,
            mu21: -mu30 * c * c * s
                + mu21 * (c * c * c - 2.0 * c * s * s)
                + mu12 * (2.0 * c * c * s - s * s * s)
                + mu03 * c * s * s,
            mu12: mu30 * c * s * s
                + mu21 * (s * s * s - 2.0 * c * c * s)
                + mu12 * (c * c * c - 2.0 * c * s * s)
                + mu03 * c * c * s,
            mu03: -mu30 * s * s * s + 3.0 * mu21 * s * s * c - 3.0 * mu12 * s * c * c
                + mu03 * c * c * c,
        }
    }

    /// Returns the moments after convolution with an isotropic kernel of variance `variance_px2`.
    #[must_use]
    pub fn with_added_variance(&self, variance_px2: f64) -> Self {
        Self {
            mu20: self.mu20 + variance_px2,
            mu02: self.mu02 + variance_px2,
            ..*self
        }
    }

    /// Returns the moments on a grid with `scale` times as many pixels along each axis.
    #[must_use]
    pub fn rescaled(&self, scale: f64) -> Self {
        let (s2, s3) = (scale * scale, scale * scale * scale);
        let [a, b, c, d, e, f, g] = self.to_array();
        Self::from_array([a * s2, b * s2, c * s2, d * s3, e * s3, f * s3, g * s3])
    }

    /// Returns the moments of the PSF mirrored along x and y, as `along` says.
    #[must_use]
    pub fn mirrored(&self, along: [bool; 2]) -> Self {
        let [x, y] = along.map(|mirrored| if mirrored { -1.0 } else { 1.0 });
        let [a, b, c, d, e, f, g] = self.to_array();
        Self::from_array([a, x * y * b, c, x * d, y * e, x * f, y * g])
    }

    /// Returns the moments of the PSF stretched along x by `factor`.
    #[must_use]
    pub fn stretched_x(&self, factor: f64) -> Self {
        let (f1, f2, f3) = (factor, factor * factor, factor * factor * factor);
        let [a, b, c, d, e, f, g] = self.to_array();
        Self::from_array([a * f2, b * f1, c, d * f3, e * f2, f * f1, g])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_keeps_the_trace_and_has_an_inverse() {
        let m = CentralMoments::from_array([3.0, -0.5, 2.0, 0.4, -0.3, 0.2, 0.9]);
        let (sin, cos) = 0.7_f64.sin_cos();
        let meridian = Meridian { cos, sin };
        let turned = m.rotated_into(meridian);
        assert!((turned.trace() - m.trace()).abs() < 1e-14);
        assert!((turned.least_variance() - m.least_variance()).abs() < 1e-14);
        let back = turned.rotated_into(meridian.inverse()).to_array();
        for (b, a) in back.iter().zip(m.to_array()) {
            assert!((b - a).abs() < 1e-14);
        }
    }
}
