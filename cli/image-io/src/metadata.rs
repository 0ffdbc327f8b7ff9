//! Metadata: what files state beside their pixels.

use exr::meta::attribute::{KeyCode, TimeCode};

/// Named texts of a file.
pub type TextAttributes = Vec<(String, String)>;

/// The prefix of the names of all provenance texts.
pub(crate) const PROVENANCE_PREFIX: &str = "seidel";

/// Returns whether a text of that name belongs to the provenance of a file.
pub(crate) fn is_provenance(name: &str) -> bool {
    name.starts_with(PROVENANCE_PREFIX)
}

/// Metadata that both EXR and DPX store, so that a conversion between the two keeps them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct CommonMetadata {
    /// SMPTE time code with its user bits.
    pub(crate) time_code: Option<TimeCode>,
    /// Frames per second, numerator and denominator.
    pub(crate) frame_rate: Option<(i32, u32)>,
    /// Owner of the image.
    pub(crate) owner: Option<String>,
    /// Date and time of capture, `YYYY:MM:DD hh:mm:ss`.
    pub(crate) capture_date: Option<String>,
    /// Camera model, or other input device.
    pub(crate) camera_model: Option<String>,
    /// Serial number of the camera.
    pub(crate) camera_serial: Option<String>,
    /// Shutter angle, degrees.
    pub(crate) shutter_angle: Option<f32>,
    /// Film key code.
    pub(crate) key_code: Option<KeyCode>,
}

// Names of EXR for common metadata.
pub(crate) const CAMERA_MODEL: &str = "cameraModel";
pub(crate) const CAMERA_SERIAL: &str = "cameraSerialNumber";
pub(crate) const SHUTTER_ANGLE: &str = "shutterAngle";
pub(crate) const KEY_CODE: &str = "keyCode";

/// Perforations per frame and per count of 35 mm film, the defaults of OpenEXR.
pub(crate) const DEFAULT_PERFORATIONS: (i32, i32) = (4, 64);

impl CommonMetadata {
    /// Returns the names of the fields that have a value, as EXR calls them.
    pub(crate) fn names(&self) -> Vec<&'static str> {
        let fields = [
            (self.time_code.is_some(), "timeCode"),
            (self.frame_rate.is_some(), "framesPerSecond"),
            (self.owner.is_some(), "owner"),
            (self.capture_date.is_some(), "capDate"),
            (self.camera_model.is_some(), CAMERA_MODEL),
            (self.camera_serial.is_some(), CAMERA_SERIAL),
            (self.shutter_angle.is_some(), SHUTTER_ANGLE),
            (self.key_code.is_some(), KEY_CODE),
        ];
        let present = fields.iter().filter(|(is_some, _)| *is_some);
        present.map(|(_, name)| *name).collect()
    }
}

/// Formats a time code as `hh:mm:ss:ff`.
pub(crate) fn time_code_text(code: &TimeCode) -> String {
    let drop_frame = if code.drop_frame { " drop frame" } else { "" };
    format!(
        "{:02}:{:02}:{:02}:{:02}{drop_frame}",
        code.hours, code.minutes, code.seconds, code.frame
    )
}

/// Returns the numbers of a key code in the order of OpenEXR, with its names.
pub(crate) fn key_code_numbers(code: &KeyCode) -> [(&'static str, i32); 7] {
    [
        ("filmMfcCode", code.film_manufacturer_code),
        ("filmType", code.film_type),
        ("prefix", code.film_roll_prefix),
        ("count", code.count),
        ("perfOffset", code.perforation_offset),
        ("perfsPerFrame", code.perforations_per_frame),
        ("perfsPerCount", code.perforations_per_count),
    ]
}

/// Formats a key code for people.
pub(crate) fn key_code_text(code: &KeyCode) -> String {
    let words = key_code_numbers(code).map(|(name, value)| format!("{name}={value}"));
    words.join(" ")
}

/// Returns a frame rate as a number; `None` if it is not positive and finite.
pub(crate) fn rate_of_fraction(fraction: (i32, u32)) -> Option<f32> {
    let (numerator, denominator) = fraction;
    let rate = f64::from(numerator) / f64::from(denominator);
    (rate.is_finite() && rate > 0.0).then_some(rate as f32)
}

/// Returns the fraction that a frame rate stands for: whole, a whole number times 1000/1001, or in thousandths.
pub(crate) fn fraction_of_rate(rate: f32) -> Option<(i32, u32)> {
    // Thousandths of higher rates exceed an `i32`.
    const MAX_RATE: f64 = 1e6;
    // Programs write 23.976 for 24000/1001.
    const TOLERANCE: f64 = 2e-5;
    let rate = f64::from(rate);
    if !(rate > 0.0 && rate <= MAX_RATE) {
        return None;
    }
    let is_near = |numerator: f64, denominator: f64| {
        numerator >= 1.0 && (numerator / denominator - rate).abs() <= TOLERANCE * rate
    };
    let (whole, ntsc) = (rate.round(), (rate * 1.001).round());
    let (numerator, denominator) = if is_near(whole, 1.0) {
        (whole, 1)
    } else if is_near(ntsc, 1.001) {
        (ntsc * 1000.0, 1001)
    } else {
        ((rate * 1000.0).round(), 1000)
    };
    (numerator >= 1.0).then_some((numerator as i32, denominator))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_rates_become_fractions() {
        for (rate, fraction) in [
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
            assert_eq!(fraction_of_rate(rate), fraction, "{rate}");
        }
        assert_eq!(rate_of_fraction((24_000, 1001)), Some(23.976_025));
        for invalid in [(1, 0), (-1, 1), (0, 0)] {
            assert_eq!(rate_of_fraction(invalid), None);
        }
    }
}
