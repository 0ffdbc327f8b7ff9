//! Focal length, focus, aperture and sensor position other than those at which the lens was measured
//! (docs/background/model.md section 10).

mod focal_length;
mod focus;

use super::{LensDescription, LensProfile, ProfileEffect, PupilChannel};
use crate::distance::ObjectDistance;
use crate::effects::ControlRatios;
use crate::error::{Error, ErrorKind, Result};
use crate::lens::VergenceSeries;
use focus::FocusedCamera;

/// Least f-number of a lens in air, whose image is lit from all sides.
const LEAST_F_NUMBER: f64 = 0.5;

/// Largest radius of the pupil over that at which the lens was measured: from f/128 to f/0.5.
const MAX_PUPIL_RATIO: f64 = 256.0;

/// Lens controls that differ from the measured ones; `None` keeps the measured value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Controls {
    /// Focal length, millimetres: all lengths of the lens and of its frame are scaled in proportion. It stays focused where it
    /// was.
    pub focal_length_mm: Option<f64>,
    /// Focused distance: the lens is sharpest there on the axis, in the mean of the channels. The distance that the profile
    /// states leaves the lens as measured.
    pub focus_distance: Option<ObjectDistance>,
    /// F-number.
    pub f_number: Option<f64>,
    /// Shift of the sensor away from the lens, micrometres; negative towards it.
    pub sensor_shift_um: Option<f64>,
}

impl Controls {
    /// A control that is left out, in words.
    pub const AS_MEASURED: &str = "as measured";

    /// Returns whether all controls keep their measured values.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns these controls, with those of `other` where they keep the measured value.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            focal_length_mm: self.focal_length_mm.or(other.focal_length_mm),
            focus_distance: self.focus_distance.or(other.focus_distance),
            f_number: self.f_number.or(other.f_number),
            sensor_shift_um: self.sensor_shift_um.or(other.sensor_shift_um),
        }
    }

    /// Returns the settings in words, for provenance.
    fn describe(&self) -> String {
        let parts = [
            self.focal_length_mm.map(|f| format!("scaled to {f} mm")),
            self.f_number.map(|n| format!("f/{n}")),
            self.focus_distance.map(|d| format!("focus at {d}")),
            self.sensor_shift_um
                .map(|s| format!("sensor moved {s} µm from the lens")),
        ];
        let parts: Vec<_> = parts.into_iter().flatten().collect();
        parts.join(", ")
    }
}

impl LensProfile {
    /// Returns the same lens with its controls set to `controls`: first the focal length, then the f-number, focus and the sensor.
    ///
    /// Parameters are scaled and shifted by the laws of docs/background/model.md section 10. The pupil magnification is
    /// taken as 1 for sensor shifts, and the symmetric blur stays. A pupil wider than measured is extrapolated; see
    /// [`LensProfile::control_warnings`]. The result has no held-out score, and its effect parameters may exceed the
    /// limits of profiles in files.
    ///
    /// # Errors
    /// [`ErrorKind::Unsupported`] for a profile of the kind `moments`, and for a focus distance if the lens was measured
    /// at one distance. Rejects invalid values, and an unknown f-number, focal length or pixel pitch that is needed.
    pub fn with_controls(&self, controls: &Controls) -> Result<Self> {
        if controls.is_empty() {
            return Ok(self.clone());
        }
        let LensDescription::Pupil(channels) = &self.description else {
            return Err(Error::new(
                "lens controls",
                "need a lens profile of the kind `pupil`; this one has the kind `moments`",
                "fit the lens with the reduced model, or leave focus, f-number and sensor as measured",
            )
            .with_kind(ErrorKind::Unsupported));
        };
        let mut channels = channels.clone();
        let mut camera = self.camera.clone();
        let mut pixel_pitch_um = self.pixel_pitch_um;
        if let Some(new_mm) = controls.focal_length_mm {
            let ratio = self.size_ratio(new_mm)?;
            channels.iter_mut().for_each(|c| c.set_size(ratio));
            camera.focal_length_mm = Some(new_mm);
            pixel_pitch_um = pixel_pitch_um.map(|pitch| pitch * ratio);
            // The lens as large stays focused where it was.
            if let Some(scaled) = focus::sharpest(&channels) {
                let focused = FocusedCamera::new(&camera, self.frame);
                focus::shift(&mut channels, scaled, scaled * ratio, &focused)?;
            }
        }
        if let Some(f_number) = controls.f_number {
            let ratio = self.pupil_ratio(f_number)?;
            channels.iter_mut().for_each(|c| c.set_pupil(ratio));
            camera.f_number = Some(f_number);
        }
        if let Some(distance) = controls.focus_distance {
            let focused = FocusedCamera::new(&camera, self.frame);
            focus::set(&mut channels, distance, &camera, &focused)?;
            camera.focus_distance = distance;
        }
        if let Some(shift_um) = controls.sensor_shift_um {
            let defocus = SensorShift::new(
                shift_um,
                camera.focal_length_mm,
                camera.f_number,
                pixel_pitch_um,
            )?;
            channels.iter_mut().for_each(|c| defocus.apply(c));
            camera.focus_distance =
                focus::sharpest(&channels).map_or(ObjectDistance::Unknown, |v| {
                    // A focus beyond infinity has no distance.
                    ObjectDistance::metres(1.0 / v.abs().max(1e-12))
                        .ok()
                        .filter(|_| v > 0.0)
                        .unwrap_or(ObjectDistance::Unknown)
                });
        }
        let mut provenance = self.provenance.clone();
        provenance.settings = format!("{}; set to {}", provenance.settings, controls.describe());
        Ok(Self {
            pixel_pitch_um,
            camera,
            description: LensDescription::Pupil(channels),
            held_out: None,
            provenance,
            ..self.clone()
        })
    }

    /// Returns warnings about the accuracy of this lens with `controls`, one sentence for each.
    pub fn control_warnings(&self, controls: &Controls) -> Vec<String> {
        let mut warnings = Vec::new();
        if let (Some(new), Some(old)) = (controls.f_number, self.camera.f_number)
            && new < old
        {
            warnings.push(format!(
                "f/{new} is wider than the f/{old} at which the lens was measured; the effect of the wider pupil is extrapolated"
            ));
        }
        if controls.focus_distance.is_some() && self.camera.focal_length_mm.is_none() {
            warnings.push(
                "the lens profile has no focal length, so aberrations are not scaled with the new focus"
                    .to_owned(),
            );
        }
        warnings
    }

    /// Returns the radius of the pupil at `f_number` over the measured one.
    fn pupil_ratio(&self, f_number: f64) -> Result<f64> {
        if !(f_number.is_finite() && f_number >= LEAST_F_NUMBER) {
            return Err(Error::new(
                "f-number",
                format!("is {f_number}"),
                format!(
                    "give at least {LEAST_F_NUMBER}, greater than zero: no lens in air is wider"
                ),
            ));
        }
        let measured = known(
            self.camera.f_number,
            "camera.f_number",
            "the f-number at which the lens was measured",
        )?;
        let ratio = measured / f_number;
        if ratio > MAX_PUPIL_RATIO {
            return Err(Error::new(
                "f-number",
                format!("is {f_number} for a lens that was measured at f/{measured}"),
                format!(
                    "the pupil may be at most {MAX_PUPIL_RATIO} times as wide as measured; check `camera.f_number` of the profile"
                ),
            ));
        }
        Ok(ratio)
    }
}

fn known(value: Option<f64>, key: &str, what: &str) -> Result<f64> {
    value.ok_or_else(|| {
        Error::new(
            key,
            "is not known",
            format!("put {what} into the lens profile, or into the manifest and fit again"),
        )
    })
}

impl PupilChannel {
    /// Scales the radius of the pupil by `ratio`.
    fn set_pupil(&mut self, ratio: f64) {
        self.alpha = self.alpha.scaled(ratio);
        self.beta = self.beta.scaled(ratio.powi(3));
        self.gamma = self.gamma.scaled(ratio);
        self.delta = self.delta.scaled(ratio);
        self.phi = self.phi.scaled(ratio.powi(2));
        self.stop_lever_m *= ratio;
        self.rescale_effects(ControlRatios {
            pupil: ratio,
            image_distance: 1.0,
        });
    }

    /// Scales the distance from the pupil to the sensor by `ratio`.
    fn set_image_distance(&mut self, ratio: f64) {
        self.alpha = self.alpha.scaled(ratio);
        self.beta = self.beta.scaled(ratio);
        self.gamma = self.gamma.scaled(1.0 / ratio);
        self.delta = self.delta.scaled(1.0 / ratio);
        self.distortion = self.distortion.scaled(ratio.powi(-2));
        self.stop_lever_m *= ratio;
        self.rescale_effects(ControlRatios {
            pupil: 1.0,
            image_distance: ratio,
        });
    }

    fn rescale_effects(&mut self, ratios: ControlRatios) {
        for carried in self.effects.iter_mut().chain(&mut self.added) {
            *carried = ProfileEffect {
                effect: carried.effect,
                values: carried.effect.rescale(&carried.values, ratios),
            };
        }
    }
}

/// The change of alpha when the sensor of a thin lens moves: a line in vergence.
pub(super) struct SensorShift {
    /// px at infinity.
    at_infinity: f64,
    /// px per 1/m.
    slope: f64,
}

impl SensorShift {
    pub(super) fn new(
        shift_um: f64,
        focal_length_mm: Option<f64>,
        f_number: Option<f64>,
        pixel_pitch_um: Option<f64>,
    ) -> Result<Self> {
        if !shift_um.is_finite() {
            return Err(Error::new(
                "sensor shift",
                format!("is {shift_um} µm"),
                "give a finite number of micrometres",
            ));
        }
        let f_mm = known(
            focal_length_mm,
            "camera.focal_length_mm",
            "the focal length",
        )?;
        let f_number = known(f_number, "camera.f_number", "the f-number")?;
        let pitch_um = known(pixel_pitch_um, "pixel_pitch_um", "the pixel pitch")?;
        // alpha = R (1 - Z2 / Z1), 1 / Z1 = 1 / f - v and R / f = 1 / (2 N); Z2 grows by the shift.
        let cone_px = shift_um / (2.0 * f_number * pitch_um);
        Ok(Self {
            at_infinity: -cone_px,
            slope: cone_px * f_mm * 1e-3,
        })
    }

    fn apply(&self, channel: &mut PupilChannel) {
        let change = self.defocus(channel);
        let (alpha, change) = (&mut channel.alpha.coefficients, change.coefficients);
        alpha.iter_mut().zip(change).for_each(|(a, b)| *a += b);
    }

    /// Returns the change of the defocus of `channel`: a constant where that does not depend on vergence.
    pub(super) fn defocus(&self, channel: &PupilChannel) -> VergenceSeries {
        let (low, high) = channel.measured_vergence;
        let line = VergenceSeries::new(vec![self.at_infinity, self.slope]);
        if channel.alpha.degree() == 0 {
            return VergenceSeries::constant(line.at((low + high) / 2.0));
        }
        line.scaled(channel.orientation())
    }
}

#[cfg(test)]
mod tests;
