//! One channel of a lens known ray by ray: five reduced numbers, a symmetric blur, effects.

use crate::effects::{Effect, ScenePoint};
use crate::field::FieldPoint;
use crate::lens::{LocalPupil, ReducedNumbers, VergenceSeries, Wavefront};
use crate::moments::CentralMoments;

/// One colour channel (`"kind": "pupil"` in files). PSF lengths in frame pixels, field in half frame
/// widths, everything a polynomial in vergence.
#[derive(Debug, Clone, PartialEq)]
pub struct PupilChannel {
    /// Channel name, such as `R` or `Y`.
    pub name: String,
    /// Defocus: (Z2 R / M)(v - vfoc) in the simplest case.
    pub alpha: VergenceSeries,
    /// Spherical aberration.
    pub beta: VergenceSeries,
    /// Astigmatism.
    pub gamma: VergenceSeries,
    /// Field curvature.
    pub delta: VergenceSeries,
    /// Coma.
    pub phi: VergenceSeries,
    /// Variance of the symmetric blur, px².
    pub blur_variance_px2: VergenceSeries,
    /// What the lens does besides.
    pub effects: Vec<ProfileEffect>,
    /// What the lens does besides all that was fitted, such as what a diagnosis found: these also move
    /// where PSFs land, which `magnification` and `distortion` hold for the lens without them.
    pub added: Vec<ProfileEffect>,
    /// Relative change of scale of where PSFs land: centroid less ideal position is
    /// X (magnification + distortion |X|²).
    pub magnification: VergenceSeries,
    /// Distortion per squared half frame width, likewise.
    pub distortion: VergenceSeries,
    /// Pupil radius over the slope of the chief ray half a frame width off the axis, m: ties stops to
    /// where they stand ([`ScenePoint::stop_lever_m`]); zero where the camera is not known.
    pub stop_lever_m: f64,
    /// Wavelength over pixel pitch; zero where either is not known.
    pub wavelength_px: f64,
    /// Least and largest vergence that were measured; all but `alpha` keep their values beyond.
    pub measured_vergence: (f64, f64),
}

/// An effect in a profile, its parameters polynomials in vergence.
#[derive(Clone)]
pub struct ProfileEffect {
    /// Which.
    pub effect: &'static dyn Effect,
    /// One series a parameter, in the effect's order.
    pub values: Vec<VergenceSeries>,
}

impl std::fmt::Debug for ProfileEffect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ProfileEffect")
            .field("effect", &self.effect.id())
            .field("values", &self.values)
            .finish()
    }
}

impl PartialEq for ProfileEffect {
    fn eq(&self, other: &Self) -> bool {
        self.effect.id() == other.effect.id() && self.values == other.values
    }
}

impl PupilChannel {
    /// The five reduced numbers at vergence `v`.
    pub fn numbers(&self, v: f64) -> ReducedNumbers {
        let held = self.held(v);
        ReducedNumbers {
            // On beyond the measured range in a straight line: defocus goes on growing.
            alpha: self.alpha.at(held) + self.alpha.slope(held) * (v - held),
            beta: self.beta.at(held),
            gamma: self.gamma.at(held),
            delta: self.delta.at(held),
            phi: self.phi.at(held),
        }
    }

    /// What the lens does to a point of light at field position `at` and vergence `v`.
    pub fn pupil_at(&self, at: FieldPoint, v: f64) -> LocalPupil {
        let mut pupil = self.fitted_pupil_at(at, v);
        self.apply(&self.added, at, v, &mut pupil);
        pupil
    }

    /// The same without [`PupilChannel::added`].
    pub fn fitted_pupil_at(&self, at: FieldPoint, v: f64) -> LocalPupil {
        let held = self.held(v);
        let mut pupil = LocalPupil::circular(
            Wavefront::third_order(&self.numbers(v), at),
            self.blur_variance_px2.at(held).max(0.0),
        );
        self.apply(&self.effects, at, v, &mut pupil);
        pupil
    }

    fn apply(&self, effects: &[ProfileEffect], at: FieldPoint, v: f64, pupil: &mut LocalPupil) {
        let (point, held) = (self.scene_point(at, v), self.held(v));
        for carried in effects {
            let values: Vec<f64> = carried.values.iter().map(|s| s.at(held)).collect();
            carried.effect.apply(&values, point, pupil);
        }
    }

    /// All that effects may depend on at field position `at` and vergence `v`.
    pub fn scene_point(&self, at: FieldPoint, v: f64) -> ScenePoint {
        ScenePoint {
            at,
            vergence_per_m: v,
            stop_lever_m: self.stop_lever_m,
            defocus_px_m: self.alpha.slope(self.held(v)),
            focus_vergence_per_m: self.focus_vergence_per_m().unwrap_or(0.0),
            wavelength_px: self.wavelength_px,
        }
    }

    /// How far the centroid lands from the ideal position, px (x, y), where half a frame width is
    /// `half_width_px`.
    pub fn displacement_at(&self, at: FieldPoint, v: f64, half_width_px: f64) -> (f64, f64) {
        let stretch = self.relative_displacement_at(at, v) * half_width_px;
        let mut moved = [at.x * stretch, at.y * stretch];
        if !self.added.is_empty() {
            let with = self.pupil_at(at, v).centroid();
            let without = self.fitted_pupil_at(at, v).centroid();
            let (point, held) = (self.scene_point(at, v), self.held(v));
            for axis in 0..2 {
                moved[axis] += with[axis] - without[axis];
            }
            for carried in &self.added {
                let values: Vec<f64> = carried.values.iter().map(|s| s.at(held)).collect();
                let shift = carried.effect.chief_ray(&values, point);
                moved = [moved[0] + shift[0], moved[1] + shift[1]];
            }
        }
        (moved[0], moved[1])
    }

    /// Vergence at which light is in focus on the axis; `None` where defocus does not depend on it.
    pub fn focus_vergence_per_m(&self) -> Option<f64> {
        // Newton's method: exact in one step where alpha is linear.
        let mut v = self.held(0.0);
        for _ in 0..20 {
            let slope = self.alpha.slope(self.held(v));
            if slope == 0.0 {
                return None;
            }
            v -= self.numbers(v).alpha / slope;
        }
        v.is_finite().then_some(v)
    }

    /// Where light of a point at field position `at` and vergence `v` lands, relative to `at`: the
    /// centroid lies at X (1 + this), [`PupilChannel::added`] apart.
    pub fn relative_displacement_at(&self, at: FieldPoint, v: f64) -> f64 {
        let held = self.held(v);
        self.magnification.at(held) + self.distortion.at(held) * (at.x * at.x + at.y * at.y)
    }

    /// Second and third central moments of the light, px² and px³, in image axes, at field position
    /// `at` and vergence `v`: the closed form where there are no effects.
    pub fn moments_at(&self, at: FieldPoint, v: f64) -> CentralMoments {
        if self.effects.is_empty() && self.added.is_empty() {
            let rays = self.numbers(v).coefficients().moments(at);
            let blur = self.blur_variance_px2.at(self.held(v)).max(0.0);
            rays.with_added_variance(blur)
        } else {
            self.pupil_at(at, v).moments().0
        }
    }

    /// Every series but those of effects, by the name that files give it.
    pub(super) fn series(&self) -> [(&'static str, &VergenceSeries); 8] {
        [
            ("alpha", &self.alpha),
            ("beta", &self.beta),
            ("gamma", &self.gamma),
            ("delta", &self.delta),
            ("phi", &self.phi),
            ("blur_variance_px2", &self.blur_variance_px2),
            ("magnification", &self.magnification),
            ("distortion", &self.distortion),
        ]
    }

    fn held(&self, v: f64) -> f64 {
        v.clamp(self.measured_vergence.0, self.measured_vergence.1)
    }
}
