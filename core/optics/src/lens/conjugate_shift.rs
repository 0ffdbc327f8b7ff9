//! The change of Seidel aberrations with object distance (docs/background/model.md section 5b).

use super::SeidelAberrations;

/// The aberrations of a lens at every object distance, from those at one.
///
/// To third order six constants determine all distances: the five aberrations and the spherical aberration A of the
/// pupil.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConjugateShift {
    /// Focal length f.
    pub focal_length: f64,
    /// Pupil magnification M.
    pub magnification: f64,
    /// Vergence v at which `intrinsic` is valid, 1 / L.
    pub vergence: f64,
    /// The aberrations at that vergence minus their geometric parts.
    pub intrinsic: SeidelAberrations,
    /// Spherical aberration A of the pupil, L.
    pub pupil_spherical: f64,
}

impl ConjugateShift {
    /// Creates the model from the aberrations `at_reference` at `vergence`, and A.
    pub fn new(
        focal_length: f64,
        magnification: f64,
        vergence: f64,
        at_reference: &SeidelAberrations,
        pupil_spherical: f64,
    ) -> Self {
        let g = geometric_part(focal_length, magnification, vergence);
        Self {
            focal_length,
            magnification,
            vergence,
            intrinsic: SeidelAberrations {
                spherical: at_reference.spherical - g.spherical,
                astigmatism: at_reference.astigmatism - g.astigmatism,
                field_curvature: at_reference.field_curvature - g.field_curvature,
                distortion: at_reference.distortion - g.distortion,
                coma: at_reference.coma - g.coma,
            },
            pupil_spherical,
        }
    }

    /// Returns the aberrations for an object at `vergence`, 1 / L.
    pub fn at(&self, vergence: f64) -> SeidelAberrations {
        let (h, a) = (&self.intrinsic, self.pupil_spherical);
        let w = vergence - self.vergence;
        let (w2, w3, w4) = (w * w, w * w * w, w * w * w * w);
        let mixed = 2.0 * h.astigmatism + h.field_curvature;
        let g = geometric_part(self.focal_length, self.magnification, vergence);
        SeidelAberrations {
            spherical: h.spherical - 4.0 * h.coma * w + 2.0 * mixed * w2 - 4.0 * h.distortion * w3
                + a * w4
                + g.spherical,
            coma: h.coma - mixed * w + 3.0 * h.distortion * w2 - a * w3 + g.coma,
            astigmatism: h.astigmatism - 2.0 * h.distortion * w + a * w2 + g.astigmatism,
            field_curvature: h.field_curvature - 2.0 * h.distortion * w
                + a * w2
                + g.field_curvature,
            distortion: h.distortion - a * w + g.distortion,
        }
    }
}

/// Returns the geometric parts, which result from referring the aberrations to the entrance pupil.
fn geometric_part(f: f64, m: f64, v: f64) -> SeidelAberrations {
    let zeta = 1.0 / (m * f) - v / (m * m);
    let curvature = -(zeta + v) / 2.0;
    SeidelAberrations {
        spherical: -(v.powi(3) + m.powi(4) * zeta.powi(3)) / 2.0,
        astigmatism: curvature,
        field_curvature: curvature,
        distortion: (1.0 - 1.0 / (m * m)) / 2.0,
        coma: (v * v - m * m * zeta * zeta) / 2.0,
    }
}
