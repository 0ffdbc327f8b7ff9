//! Published paraxial figures of the prescriptions, from the sources that `prescription` names.

use super::super::prescription::{
    ANGENIEUX, CANON, COOKE_TRIPLET, DOUBLE_GAUSS, Prescription, TESSAR, US_8879901,
};

/// Paraxial figures of a lens for an object at infinity.
#[derive(Debug)]
pub(super) struct Published {
    pub(super) lens: &'static Prescription,
    /// Wavelength, nm.
    pub(super) nm: f64,
    /// Focal length, length units of the prescription.
    pub(super) focal: f64,
    /// Distance from the last surface to the focus.
    pub(super) back: f64,
    /// Largest error of the focal length over it: an engraved one is rounded.
    pub(super) focal_accuracy: f64,
    /// Largest error of the back focus over the focal length: a sensor stands off the paraxial focus.
    pub(super) back_accuracy: f64,
}

pub(super) static PUBLISHED: [Published; 6] = [
    Published {
        lens: &COOKE_TRIPLET,
        nm: 550.0,
        focal: 49.999_783,
        back: 42.414_858,
        focal_accuracy: 1e-4,
        back_accuracy: 1e-4,
    },
    Published {
        lens: &DOUBLE_GAUSS,
        nm: 587.6,
        focal: 100.003_748,
        back: 61.487_546,
        focal_accuracy: 1e-4,
        back_accuracy: 1e-4,
    },
    Published {
        lens: &TESSAR,
        nm: 587.5618,
        focal: 3.997_778,
        back: 3.418_755,
        focal_accuracy: 1e-4,
        back_accuracy: 1e-4,
    },
    Published {
        lens: &CANON,
        nm: 587.5618,
        focal: 50.0,
        back: 37.93,
        focal_accuracy: 0.04,
        back_accuracy: 1e-4,
    },
    Published {
        lens: &ANGENIEUX,
        nm: 587.5618,
        focal: 100.0,
        back: 55.724,
        focal_accuracy: 2e-3,
        back_accuracy: 3e-3,
    },
    Published {
        lens: &US_8879901,
        nm: 587.5618,
        focal: 35.975_682,
        back: 3.497_090,
        focal_accuracy: 1e-4,
        back_accuracy: 1e-4,
    },
];
