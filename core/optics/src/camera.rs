//! The known settings of the camera that took a set of observations.

use std::collections::BTreeMap;

use crate::distance::ObjectDistance;

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
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            focal_length_mm: None,
            f_number: None,
            focus_distance: ObjectDistance::Unknown,
            wavelength_nm: BTreeMap::new(),
            squeeze: None,
        }
    }
}
