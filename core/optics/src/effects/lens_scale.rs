//! The units of a lens and its camera, in which amounts of effects are stated.
//!
//! Defocus in px at the rim of the pupil becomes a length at the sensor by the cone of light, whose slope is
//! 1 / (2 N) (docs/background/model.md section 10).

/// Units of a lens and its camera; [`LensProfile::scale`](crate::profile::LensProfile::scale) returns them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LensScale {
    /// Half the width of the frame, px.
    pub half_width_px: f64,
    /// Pixel pitch, µm.
    pub pitch_um: Option<f64>,
    /// Stated f-number.
    pub f_number: Option<f64>,
    /// F-number of the cone of light at the sensor.
    pub cone: Option<f64>,
    /// Derivative of defocus by vergence, px m; `None` for a lens measured at one distance.
    pub slope_px_m: Option<f64>,
    /// Vergence in focus, 1/m.
    pub focus_per_m: Option<f64>,
}

impl LensScale {
    /// Returns the millimetres at the sensor of one px of defocus.
    pub(super) fn mm_per_px(&self) -> Option<f64> {
        Some(2.0 * self.cone? * self.pitch_um? * 1e-3)
    }

    /// Returns the sign of the sensor's shift away from the lens that adds positive defocus; `None` if not known.
    pub(super) fn sign(&self) -> Option<f64> {
        self.slope_px_m.map(|slope| -slope.signum())
    }

    /// Returns the words "behind" or "in front of" for a sensor with the extra defocus `alpha`.
    pub(super) fn side(&self, alpha: f64) -> Option<&'static str> {
        // The sensor lies farther from the lens where this is positive.
        let shift = self.sign()? * alpha;
        Some(if shift > 0.0 { "behind" } else { "in front of" })
    }
}
