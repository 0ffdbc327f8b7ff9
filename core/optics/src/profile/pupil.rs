//! Channels of lens profiles of the kind `pupil`: five reduced numbers, a symmetric blur and effects.

use crate::effects::{Effect, ScenePoint};
use crate::field::FieldPoint;
use crate::lens::{LocalPupil, PictureMask, ReducedNumbers, VergenceSeries, Wavefront};
use crate::moments::CentralMoments;

/// A colour channel of the kind `pupil`, with parameters that are polynomials in vergence.
///
/// PSF lengths are in frame pixels, field lengths in half frame widths.
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
    /// Fitted effects, in the order of [`crate::effects::ALL`].
    pub effects: Vec<ProfileEffect>,
    /// Effects added after the fit, such as those that a diagnosis found. They also change the displacement;
    /// `magnification` and `distortion` are those of the lens without them.
    pub added: Vec<ProfileEffect>,
    /// A picture of the aperture, which acts after all effects. Files do not hold it.
    pub picture: Option<PictureMask>,
    /// Relative change of scale: centroid minus ideal position is X (magnification + distortion |X|²).
    pub magnification: VergenceSeries,
    /// Distortion per squared half frame width.
    pub distortion: VergenceSeries,
    /// Pupil radius over the slope of the chief ray half a frame width off the axis, m
    /// ([`ScenePoint::stop_lever_m`]); zero if the camera is unknown.
    pub stop_lever_m: f64,
    /// Wavelength over pixel pitch; zero if either is unknown.
    pub wavelength_px: f64,
    /// Smallest and largest measured vergence, 1/m. Defocus, `alpha` and that of effects, is linear beyond; all other series are
    /// constant there.
    pub measured_vergence: (f64, f64),
}

/// An effect in a profile, with parameters that are polynomials in vergence.
#[derive(Clone)]
pub struct ProfileEffect {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// One series a parameter, in the order of the effect.
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

impl ProfileEffect {
    /// Returns the values at vergence `v` of an effect measured over `range` of vergence.
    fn values_at(&self, range: (f64, f64), v: f64) -> Vec<f64> {
        let defocus = self.defocus_count();
        let clamped = v.clamp(range.0, range.1);
        let at = |(k, series): (usize, &VergenceSeries)| match k < defocus {
            true => series.linear_beyond(range, v),
            false => series.at(clamped),
        };
        self.values.iter().enumerate().map(at).collect()
    }

    /// Returns the number of parameters that are defocus, the first ones.
    fn defocus_count(&self) -> usize {
        self.effect.description().fit.linear
    }
}

impl PupilChannel {
    /// Returns the five reduced numbers at vergence `v`, 1/m.
    pub fn numbers(&self, v: f64) -> ReducedNumbers {
        let clamped = self.clamped(v);
        ReducedNumbers {
            alpha: self.alpha.linear_beyond(self.measured_vergence, v),
            beta: self.beta.at(clamped),
            gamma: self.gamma.at(clamped),
            delta: self.delta.at(clamped),
            phi: self.phi.at(clamped),
        }
    }

    /// Returns the pupil for a point at field position `at` and vergence `v`, with all effects.
    pub fn pupil_at(&self, at: FieldPoint, v: f64) -> LocalPupil {
        let mut pupil = self.fitted_pupil_at(at, v);
        self.apply(&self.added, at, v, &mut pupil);
        pupil.transmission.picture.clone_from(&self.picture);
        pupil
    }

    /// Returns the pupil like [`PupilChannel::pupil_at`], without [`PupilChannel::added`] and the picture.
    pub fn fitted_pupil_at(&self, at: FieldPoint, v: f64) -> LocalPupil {
        let clamped = self.clamped(v);
        let mut pupil = LocalPupil::circular(
            Wavefront::third_order(&self.numbers(v), at),
            self.blur_variance_px2.at(clamped).max(0.0),
        );
        self.apply(&self.effects, at, v, &mut pupil);
        pupil
    }

    fn apply(&self, effects: &[ProfileEffect], at: FieldPoint, v: f64, pupil: &mut LocalPupil) {
        let point = self.scene_point(at, v);
        for carried in effects {
            let values = carried.values_at(self.measured_vergence, v);
            carried.effect.apply(&values, point, pupil);
        }
    }

    /// Returns the input of effects at field position `at` and vergence `v`.
    pub fn scene_point(&self, at: FieldPoint, v: f64) -> ScenePoint {
        ScenePoint {
            at,
            vergence_per_m: v,
            stop_lever_m: self.stop_lever_m,
            defocus_px_m: self.alpha.slope(self.clamped(v)),
            focus_vergence_per_m: self.focus_vergence_per_m().unwrap_or(0.0),
            wavelength_px: self.wavelength_px,
        }
    }

    /// Returns the displacement of the centroid from the ideal position (x, y), px, for a frame of half width
    /// `half_width_px`.
    pub fn displacement_at(&self, at: FieldPoint, v: f64, half_width_px: f64) -> (f64, f64) {
        let stretch = self.relative_displacement_at(at, v) * half_width_px;
        let mut moved = [at.x * stretch, at.y * stretch];
        for carried in self
            .effects
            .iter()
            .filter(|c| c.effect.description().fits_chief_ray)
        {
            let values = carried.values_at(self.measured_vergence, v);
            let shift = (carried.effect).chief_ray(&values, self.scene_point(at, v));
            moved = [moved[0] + shift[0], moved[1] + shift[1]];
        }
        if !self.added.is_empty() || self.picture.is_some() {
            let with = self.pupil_at(at, v).centroid();
            let without = self.fitted_pupil_at(at, v).centroid();
            let point = self.scene_point(at, v);
            for axis in 0..2 {
                moved[axis] += with[axis] - without[axis];
            }
            for carried in &self.added {
                let values = carried.values_at(self.measured_vergence, v);
                let shift = carried.effect.chief_ray(&values, point);
                moved = [moved[0] + shift[0], moved[1] + shift[1]];
            }
        }
        (moved[0], moved[1])
    }

    /// Returns the vergence in focus on the axis; `None` if defocus does not depend on vergence.
    pub fn focus_vergence_per_m(&self) -> Option<f64> {
        // Newton's method: exact in one step where alpha is linear.
        let mut v = self.clamped(0.0);
        for _ in 0..20 {
            let slope = self.alpha.slope(self.clamped(v));
            if slope == 0.0 {
                return None;
            }
            v -= self.numbers(v).alpha / slope;
        }
        v.is_finite().then_some(v)
    }

    /// Returns the relative displacement r at field position `at` and vergence `v`: the centroid lies at X (1 + r),
    /// without [`PupilChannel::added`].
    pub fn relative_displacement_at(&self, at: FieldPoint, v: f64) -> f64 {
        let clamped = self.clamped(v);
        self.magnification.at(clamped) + self.distortion.at(clamped) * (at.x * at.x + at.y * at.y)
    }

    /// Returns the second and third central moments (image axes, px² and px³) at field position `at` and vergence `v`.
    ///
    /// Uses the closed form if there are no effects, otherwise quadrature.
    pub fn moments_at(&self, at: FieldPoint, v: f64) -> CentralMoments {
        self.closed_form_moments(at, v)
            .unwrap_or_else(|| self.pupil_at(at, v).moments().0)
    }

    /// Returns the moments as [`PupilChannel::moments_at`], and the pupil.
    pub(crate) fn moments_and_pupil_at(
        &self,
        at: FieldPoint,
        v: f64,
    ) -> (CentralMoments, LocalPupil) {
        let pupil = self.pupil_at(at, v);
        let moments = self.closed_form_moments(at, v);
        (moments.unwrap_or_else(|| pupil.moments().0), pupil)
    }

    /// Returns the moments of a lens without effects.
    fn closed_form_moments(&self, at: FieldPoint, v: f64) -> Option<CentralMoments> {
        let is_plain = self.effects.is_empty() && self.added.is_empty() && self.picture.is_none();
        is_plain.then(|| {
            let rays = self.numbers(v).coefficients().moments(at);
            let blur = self.blur_variance_px2.at(self.clamped(v)).max(0.0);
            rays.with_added_variance(blur)
        })
    }

    /// Returns whether defocus depends on vergence.
    pub(super) fn depends_on_vergence(&self) -> bool {
        self.alpha.degree() > 0 && self.alpha.slope(self.clamped(0.0)) != 0.0
    }

    /// Returns -1 if the fit found the pupil inverted, which gives the same PSFs: then defocus falls with vergence. Otherwise 1.
    pub(super) fn orientation(&self) -> f64 {
        let (low, high) = self.measured_vergence;
        let slope = self.alpha.slope((low + high) / 2.0);
        if slope < 0.0 { -1.0 } else { 1.0 }
    }

    /// Returns the series of defocus: `alpha`, and those of effects that follow the object's distance.
    pub(super) fn defocus_series(&self) -> impl Iterator<Item = &VergenceSeries> {
        let effects = self.effects.iter().chain(&self.added);
        std::iter::once(&self.alpha)
            .chain(effects.flat_map(|carried| &carried.values[..carried.defocus_count()]))
    }

    /// Returns the same as [`Self::defocus_series`], to be changed.
    pub(super) fn defocus_series_mut(&mut self) -> impl Iterator<Item = &mut VergenceSeries> {
        let effects = self.effects.iter_mut().chain(&mut self.added);
        std::iter::once(&mut self.alpha).chain(effects.flat_map(|carried| {
            let count = carried.defocus_count();
            &mut carried.values[..count]
        }))
    }

    /// Returns all series except those of effects, with their names in files.
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

    /// Returns all series, those of effects included.
    pub fn series_mut(&mut self) -> impl Iterator<Item = &mut VergenceSeries> {
        let effects = self.effects.iter_mut().chain(&mut self.added);
        [
            &mut self.alpha,
            &mut self.beta,
            &mut self.gamma,
            &mut self.delta,
            &mut self.phi,
            &mut self.blur_variance_px2,
            &mut self.magnification,
            &mut self.distortion,
        ]
        .into_iter()
        .chain(effects.flat_map(|carried| &mut carried.values))
    }

    /// Returns `v` clamped to the measured range.
    fn clamped(&self, v: f64) -> f64 {
        v.clamp(self.measured_vergence.0, self.measured_vergence.1)
    }
}
