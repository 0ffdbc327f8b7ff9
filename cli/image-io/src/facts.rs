//! What both EXR and DPX say of a picture beside its pixels, so that it goes from one to the other.

use exr::meta::attribute::{KeyCode, TimeCode};

/// Facts of a picture.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Facts {
    /// SMPTE time code with its user bits.
    pub(crate) time_code: Option<TimeCode>,
    /// Frames per second, as a fraction.
    pub(crate) frame_rate: Option<(i32, u32)>,
    /// Whose it is.
    pub(crate) owner: Option<String>,
    /// When it was made, `YYYY:MM:DD hh:mm:ss`.
    pub(crate) captured: Option<String>,
    /// The camera, or what else it came from.
    pub(crate) device: Option<String>,
    /// The number of that.
    pub(crate) serial: Option<String>,
    /// How far the shutter was open, degrees.
    pub(crate) shutter_angle: Option<f32>,
    /// Where on the film it was.
    pub(crate) key_code: Option<KeyCode>,
}

/// EXR's standard attributes that DPX has no place for in a form of the format's own.
pub(crate) const CAMERA_MODEL: &str = "cameraModel";
pub(crate) const CAMERA_SERIAL: &str = "cameraSerialNumber";
pub(crate) const SHUTTER_ANGLE: &str = "shutterAngle";

impl Facts {
    /// Those that there are, by the names of EXR's attributes.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let named = [
            (self.time_code.is_some(), "timeCode"),
            (self.frame_rate.is_some(), "framesPerSecond"),
            (self.owner.is_some(), "owner"),
            (self.captured.is_some(), "capDate"),
            (self.device.is_some(), CAMERA_MODEL),
            (self.serial.is_some(), CAMERA_SERIAL),
            (self.shutter_angle.is_some(), SHUTTER_ANGLE),
            (self.key_code.is_some(), crate::exr::key_code::NAME),
        ];
        let there = named.iter().filter(|(is, _)| *is);
        there.map(|(_, name)| *name).collect()
    }
}

/// The frame rate of an EXR's fraction; `None` for what is none.
pub(crate) fn rate((over, under): (i32, u32)) -> Option<f32> {
    let rate = f64::from(over) / f64::from(under);
    (rate.is_finite() && rate > 0.0).then_some(rate as f32)
}

/// The fraction that a frame rate stands for: whole, whole times 1000/1001, or in thousandths.
pub(crate) fn fraction(rate: f32) -> Option<(i32, u32)> {
    // Above, thousandths are no `i32`, and nothing is filmed.
    const MOST: f64 = 1e6;
    let rate = f64::from(rate);
    if !(rate > 0.0 && rate <= MOST) {
        return None;
    }
    // As near as programs write such rates.
    let near = |over: f64, under: f64| over >= 1.0 && (over / under - rate).abs() <= 2e-5 * rate;
    let (whole, ntsc) = (rate.round(), (rate * 1.001).round());
    let (over, under) = match () {
        () if near(whole, 1.0) => (whole, 1.0),
        () if near(ntsc, 1.001) => (ntsc * 1000.0, 1001.0),
        () => ((rate * 1000.0).round(), 1000.0),
    };
    (over >= 1.0).then_some((over as i32, under as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_rates_are_the_fractions_that_they_stand_for() {
        for (value, want) in [
            (24.0, Some((24, 1))),
            (23.976, Some((24_000, 1001))),
            (23.976_025, Some((24_000, 1001))),
            (29.97, Some((30_000, 1001))),
            (59.94, Some((60_000, 1001))),
            (12.5, Some((12_500, 1000))),
            (0.0, None),
            (-1.0, None),
            (f32::NAN, None),
            (f32::INFINITY, None),
            (1e-9, None),
        ] {
            assert_eq!(fraction(value), want, "{value}");
        }
        assert_eq!(rate((24_000, 1001)), Some(23.976_025));
        assert_eq!(
            (rate((1, 0)), rate((-1, 1)), rate((0, 0))),
            (None, None, None)
        );
    }
}
