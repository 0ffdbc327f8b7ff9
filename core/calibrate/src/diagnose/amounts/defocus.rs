//! Defocus as a length at the sensor and as a distance in focus.
//!
//! Defocus in px at the rim of the pupil becomes a length at the sensor by the cone of light, whose slope is
//! 1 / (2 N) (docs/background/model.md section 10).

use seidel_optics::profile::LensProfile;

use super::quantity::{Fitted, joined, quantity};

/// The defocus of a lens: its change with vergence, and the length at the sensor that it stands for.
struct DefocusScale {
    /// Derivative of defocus by vergence, px m; `None` for a lens measured at one distance.
    slope_px_m: Option<f64>,
    /// Vergence in focus, 1/m.
    focus_per_m: Option<f64>,
    /// F-number of the cone of light at the sensor.
    cone: Option<f64>,
    pitch_um: Option<f64>,
}

impl DefocusScale {
    fn of(lens: &LensProfile) -> Self {
        let channels = lens.pupil_channels();
        let mean = |values: Vec<f64>| {
            let count = values.len();
            (count > 0 && count == channels.len())
                .then(|| values.iter().sum::<f64>() / count as f64)
        };
        let slopes = channels.iter().filter_map(|channel| {
            let (low, high) = channel.measured_vergence;
            let slope = channel.alpha.slope((low + high) / 2.0);
            (slope != 0.0).then_some(slope)
        });
        let focus = channels.iter().filter_map(|c| c.focus_vergence_per_m());
        let fitted = mean(focus.collect());
        let camera = &lens.camera;
        let focus_per_m = fitted.or_else(|| camera.focus_distance.vergence_per_m());
        let nearer =
            1.0 - camera.focal_length_mm.unwrap_or(0.0) * 1e-3 * focus_per_m.unwrap_or(0.0);
        Self {
            slope_px_m: mean(slopes.collect()),
            focus_per_m,
            cone: camera.f_number.filter(|_| nearer > 0.0).map(|n| n / nearer),
            pitch_um: lens.pixel_pitch_um,
        }
    }

    /// Returns the millimetres at the sensor of one px of defocus.
    fn mm_per_px(&self) -> Option<f64> {
        Some(2.0 * self.cone? * self.pitch_um? * 1e-3)
    }

    /// Returns the sign of the sensor's shift away from the lens that adds positive defocus; `None` if not known.
    fn sign(&self) -> Option<f64> {
        self.slope_px_m.map(|slope| -slope.signum())
    }

    /// Returns the words "behind" or "in front of" for a sensor with the extra defocus `alpha`.
    fn side(&self, alpha: f64) -> Option<&'static str> {
        // The sensor lies farther from the lens where this is positive.
        let shift = self.sign()? * alpha;
        Some(if shift > 0.0 { "behind" } else { "in front of" })
    }
}

/// Returns the position of the sensor, and the distance in focus that it stands for.
pub(super) fn focus_offset(fitted: &Fitted, lens: &LensProfile) -> Option<String> {
    let alpha = fitted.of("alpha")?;
    let scale = DefocusScale::of(lens);
    let sensor = match (scale.mm_per_px(), scale.side(alpha.value)) {
        (Some(mm), Some(side)) => {
            let length = alpha.quantity(mm, "mm");
            format!("the sensor sits {length} {side} the stated focus")
        }
        (Some(mm), None) => format!(
            "the sensor sits {} off the stated focus, on a side that one distance does not show",
            alpha.quantity(mm, "mm")
        ),
        _ => format!(
            "points in focus become discs of {} radius",
            alpha.quantity(1.0, "px")
        ),
    };
    let focus = |slope: f64, stated: f64| {
        let found = stated - alpha.value / slope;
        format!(
            "the paraxial focus is at {}, that of the profile at {}",
            metres(found),
            metres(stated)
        )
    };
    Some(match (scale.slope_px_m, scale.focus_per_m) {
        (Some(slope), Some(stated)) => format!("{sensor}: {}", focus(slope, stated)),
        _ => sensor,
    })
}

/// Formats the distance of vergence `v`, 1/m.
fn metres(v: f64) -> String {
    if v < -1e-3 {
        "beyond infinity".to_owned()
    } else if v < 1e-3 {
        "infinity".to_owned()
    } else {
        quantity(1.0 / v, 0.0, "m")
    }
}

/// Returns the angle of the sensor and the side that is farther from the lens.
pub(super) fn sensor_tilt(fitted: &Fitted, lens: &LensProfile) -> Option<String> {
    let tilt = fitted.vector("tilt_x", "tilt_y")?;
    let scale = DefocusScale::of(lens);
    // px of defocus a half frame width are this length along the axis over one across, for small angles.
    let angle = scale.cone.map(|cone| {
        let tangent = 2.0 * cone / lens.frame.half_width_px();
        tilt.quantity(tangent.to_degrees(), "degrees")
    });
    Some(match (angle, scale.sign()) {
        (Some(angle), Some(sign)) => format!(
            "the sensor is tilted by {angle}, its far side towards {} of the picture",
            tilt.direction(sign)
        ),
        (Some(angle), None) => format!("the sensor is tilted by {angle}"),
        _ => format!(
            "defocus changes by {} from the middle to the side of the frame, towards {}",
            tilt.quantity(1.0, "px"),
            tilt.direction(1.0)
        ),
    })
}

/// Returns the distance between the foci of each channel and of the middle one.
pub(super) fn axial_colour(fitted: &Fitted, lens: &LensProfile) -> Option<String> {
    let scale = DefocusScale::of(lens);
    let channels: Vec<String> = fitted
        .by_channel("alpha")
        .map(
            |(channel, alpha)| match (scale.mm_per_px(), scale.side(-alpha.value)) {
                (Some(mm), Some(side)) => format!(
                    "channel {channel} focuses {} {side} the middle channel",
                    alpha.quantity(mm, "mm")
                ),
                _ => format!(
                    "channel {channel} is {} out of focus against the middle channel",
                    alpha.quantity(1.0, "px")
                ),
            },
        )
        .collect();
    joined(channels)
}
