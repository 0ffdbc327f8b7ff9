//! The plane of focus of a lens before a tilted sensor.

use std::fmt;

use crate::effects::amount::direction_in_picture;
use crate::effects::{Effect, SensorTilt};
use crate::profile::LensProfile;

/// Tilt below which the plane of focus counts as square to the axis, degrees.
const LEAST_TILT_DEG: f64 = 0.5;

/// The plane of objects that are in focus, where the sensor is not square to the axis: Scheimpflug's rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneOfFocus {
    /// Distance from the entrance pupil at which it crosses the axis, m; infinite if it runs along the axis.
    pub on_axis_m: f64,
    /// Angle between it and a plane square to the axis, degrees.
    pub tilt_deg: f64,
    /// Unit vector in the picture, x to the right and y down, along which it comes nearer.
    pub nearer: [f64; 2],
}

impl LensProfile {
    /// Returns the plane of focus of the first channel, to first order; `None` if the sensor is not tilted, or if the
    /// focal length or the pixel pitch is unknown.
    ///
    /// Defocus a + s v + t X of a point at vergence v = 1/z, drawn at X = k (x, y) / z half frame widths from the axis, is zero on
    /// the plane a z + s + k t (x, y) = 0.
    pub fn plane_of_focus(&self) -> Option<PlaneOfFocus> {
        let channel = self.pupil_channels().first()?;
        let half_width_m = self.frame.half_width_px() * self.pixel_pitch_um? * 1e-6;
        let focal_m = self.camera.focal_length_mm? * 1e-3;
        let focus = self.camera.focus_distance.vergence_per_m().unwrap_or(0.0);
        let k = focal_m / (1.0 - focal_m * focus) / half_width_m;
        // A line through defocus about the middle of the measured range.
        let (far, near) = channel.measured_vergence;
        let v = (far + near) / 2.0;
        let [before, after] = [v - 0.5, v + 0.5].map(|v| channel.numbers(v).alpha);
        let slope = after - before;
        let constant = channel.numbers(v).alpha - slope * v;
        let effects = channel.effects.iter().chain(&channel.added);
        let tilted = effects.filter(|carried| carried.effect.id() == SensorTilt.id());
        let tilt = tilted.fold([0.0; 2], |sum, carried| {
            [0, 1].map(|axis| sum[axis] + carried.values[axis].at(v))
        });
        let size = tilt[0].hypot(tilt[1]);
        let found = PlaneOfFocus {
            on_axis_m: (slope / constant).abs(),
            tilt_deg: (k * size).atan2(constant.abs()).to_degrees(),
            // On the plane, -a z = s + k t (x, y).
            nearer: tilt.map(|t| t / size * constant.signum()),
        };
        (size > 0.0 && found.tilt_deg > LEAST_TILT_DEG).then_some(found)
    }
}

impl fmt::Display for PlaneOfFocus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the plane of focus crosses the axis at {:.2} m, tilted by {:.0} degrees: it comes nearer towards {} of the picture",
            self.on_axis_m,
            self.tilt_deg,
            direction_in_picture(self.nearer)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{amount, neutral};
    use crate::lens::VergenceSeries;
    use crate::profile::{LensDescription, ProfileEffect};

    #[test]
    fn the_plane_of_focus_is_that_of_scheimpflugs_rule() {
        // 50 mm at f/2 on 2 m, with 600 px of 5 um: sensor, lens and plane of focus meet in a line.
        let mut lens = amount::tests::lens(1.0);
        let tangent = 2.0_f64.to_radians().tan();
        let image_m = 0.05 / 0.975;
        // A point half a frame width up, at z behind the untilted sensor, is a disc of radius R z / Z2.
        let half_width_m = 300.0 * 5e-6;
        let behind_px = tangent * half_width_m * 0.0125 / image_m / 5e-6;
        let mut values = neutral(&SensorTilt);
        values[1] = -behind_px;
        let LensDescription::Pupil(channels) = &mut lens.description else {
            panic!("a lens of rays");
        };
        channels[0].effects.push(ProfileEffect {
            effect: &SensorTilt,
            values: values.into_iter().map(VergenceSeries::constant).collect(),
        });
        let plane = lens.plane_of_focus().expect("tilted");
        assert!((plane.on_axis_m - 2.0).abs() < 1e-9, "{plane:?}");
        let want = (2.0 / image_m * tangent).atan().to_degrees();
        assert!((plane.tilt_deg - want).abs() < 1e-6, "{plane:?} {want}");
        // A point that is nearer than 2 m is in focus half way down to the side of the frame.
        let slope = lens.pupil_channels()[0].numbers(1.0).alpha / 0.5;
        let nearer = 0.5 + 0.5 * behind_px / slope;
        let defocus = lens.pupil_channels()[0].numbers(nearer).alpha - 0.5 * behind_px;
        assert!(defocus.abs() < 1e-9, "{defocus}");
        assert_eq!(plane.nearer[1], 1.0, "{plane:?}");
        assert!(
            plane
                .to_string()
                .ends_with("towards the bottom of the picture")
        );
    }
}
