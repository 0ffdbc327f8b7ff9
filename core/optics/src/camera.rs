//! The known settings of the camera that took a set of observations.

use std::collections::BTreeMap;

use crate::distance::ObjectDistance;
use crate::error::{Error, Result};

/// Wavelengths that a camera can have, nanometres: from far ultraviolet to thermal infrared. A number in micrometres or
/// metres lies outside.
const WAVELENGTHS_NM: std::ops::RangeInclusive<f64> = 100.0..=20_000.0;

/// The known settings of a camera; every one may be missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Focal length, millimetres.
    pub focal_length_mm: Option<f64>,
    /// F-number: focal length over entrance-pupil diameter.
    pub f_number: Option<f64>,
    /// Focused object distance.
    pub focus_distance: ObjectDistance,
    /// Wavelength of each channel, nanometres, by channel name.
    pub wavelength_nm: BTreeMap<String, f64>,
    /// Squeeze of an anamorphic lens: the width of a thing over its height, divided by that of its image; 2 for a 2x lens,
    /// 1 for a spherical one.
    pub squeeze: Option<f64>,
    /// Name of the lens, by which a shot's lens is compared with it.
    pub lens_model: Option<String>,
    /// Serial number of the lens.
    pub lens_serial_number: Option<String>,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            focal_length_mm: None,
            f_number: None,
            focus_distance: ObjectDistance::Unknown,
            wavelength_nm: BTreeMap::new(),
            squeeze: None,
            lens_model: None,
            lens_serial_number: None,
        }
    }
}

impl Camera {
    /// Checks the wavelengths of a camera with these `channels`.
    ///
    /// # Errors
    /// The first wavelength of a channel that is not in `channels`, or outside 100 to 20000 nm.
    pub fn check_wavelengths(&self, channels: &[&str]) -> Result<()> {
        for (name, nm) in &self.wavelength_nm {
            let place = format!("camera.wavelength_nm.{name}");
            if !channels.contains(&name.as_str()) {
                let remedy = format!("name one of the channels: {}", channels.join(", "));
                return Err(Error::new(
                    place,
                    "is of a channel that does not exist",
                    remedy,
                ));
            }
            if !WAVELENGTHS_NM.contains(nm) {
                let remedy = format!(
                    "give nanometres from {} to {}, or leave it out",
                    WAVELENGTHS_NM.start(),
                    WAVELENGTHS_NM.end()
                );
                return Err(Error::new(place, format!("is {nm}"), remedy));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_are_of_known_channels_and_in_nanometres() {
        let check = |name: &str, nm: f64| {
            let camera = Camera {
                wavelength_nm: BTreeMap::from([(name.to_owned(), nm)]),
                ..Camera::default()
            };
            camera.check_wavelengths(&["R", "G"])
        };
        check("R", 620.0).expect("a wavelength");
        for bad in [0.0, -1.0, 0.55, 5.5e-7, 1e9, f64::NAN, f64::INFINITY] {
            let error = check("G", bad).expect_err("no wavelength");
            assert_eq!(error.place, "camera.wavelength_nm.G");
            assert!(error.remedy.contains("nanometres"), "{error}");
        }
        let error = check("X", 620.0).expect_err("no channel");
        assert!(error.remedy.contains("R, G"), "{error}");
    }
}
