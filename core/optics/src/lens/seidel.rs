//! Third-order (Seidel) aberrations of a physical lens.

use super::{Conjugates, ReducedNumbers};
use crate::field::FieldPoint;

/// Seidel aberration coefficients of the ray map (Eqs 5-6), in the length unit L of the thick lens.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SeidelAberrations {
    /// B: spherical aberration, L^-3.
    pub spherical: f64,
    /// C: astigmatism, L^-1.
    pub astigmatism: f64,
    /// D: field curvature, L^-1.
    pub field_curvature: f64,
    /// E: distortion, dimensionless. Changes centroids only.
    pub distortion: f64,
    /// F: coma, L^-2.
    pub coma: f64,
}

impl SeidelAberrations {
    /// Returns the five reduced numbers of the X-frame (docs/background/model.md section 3).
    ///
    /// `pupil_radius` is R. Field positions and PSFs are in the length unit of the lens.
    pub fn reduced(&self, at: &Conjugates, pupil_radius: f64) -> ReducedNumbers {
        let (m, z2, r) = (at.magnification, at.z2, pupil_radius);
        ReducedNumbers {
            alpha: at.defocus_slope() * r,
            beta: self.spherical * z2 * r.powi(3) / m,
            gamma: 2.0 * self.astigmatism * m * r / z2,
            delta: self.field_curvature * m * r / z2,
            phi: self.coma * r * r,
        }
    }

    /// Returns the centroid of the PSF at ideal position `x`: X (1 - E M² |X|² / Z2² - F R²).
    ///
    /// Positions are in the length unit of the lens.
    pub fn centroid(&self, at: &Conjugates, pupil_radius: f64, x: FieldPoint) -> FieldPoint {
        let h2 = x.x * x.x + x.y * x.y;
        let (m, z2) = (at.magnification, at.z2);
        let scale = 1.0
            - self.distortion * m * m * h2 / (z2 * z2)
            - self.coma * pupil_radius * pupil_radius;
        FieldPoint::new(x.x * scale, x.y * scale)
    }
}
