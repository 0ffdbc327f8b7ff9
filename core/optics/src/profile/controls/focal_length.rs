//! A lens scaled in proportion to another focal length.
//!
//! All lengths of the lens, of its frame and of the scene times k give the same rays. So in frame pixels the lens that is k
//! times as large blurs an object at distance k z as the measured one does at distance z: every series in vergence is that of
//! the measured lens at k v. Frame pixels are k times as wide, the f-number stays.

use super::known;
use crate::error::{Error, Result};
use crate::profile::{LensProfile, PupilChannel};

/// Largest ratio of the new focal length to the measured one, or of the measured one to the new: a fisheye and a long telephoto lens.
const MAX_SIZE_RATIO: f64 = 64.0;

impl LensProfile {
    /// Returns the focal length `new_mm` over the measured one.
    ///
    /// # Errors
    /// An unknown measured focal length, and a ratio outside 1/64 to 64.
    pub(super) fn size_ratio(&self, new_mm: f64) -> Result<f64> {
        let measured = known(
            self.camera.focal_length_mm,
            "camera.focal_length_mm",
            "the focal length at which the lens was measured",
        )?;
        let ratio = new_mm / measured;
        if (1.0 / MAX_SIZE_RATIO..=MAX_SIZE_RATIO).contains(&ratio) {
            return Ok(ratio);
        }
        Err(Error::new(
            "focal length",
            format!("is {new_mm} mm for a lens of {measured} mm"),
            format!(
                "give millimetres: at most {MAX_SIZE_RATIO} times the measured focal length, and no less than 1/{MAX_SIZE_RATIO} of it"
            ),
        ))
    }
}

impl PupilChannel {
    /// Scales all lengths of the lens and of its frame by `ratio`.
    pub(super) fn set_size(&mut self, ratio: f64) {
        for series in self.series_mut() {
            *series = series.stretched(ratio);
        }
        self.stop_lever_m *= ratio;
        self.wavelength_px /= ratio;
        let (low, high) = self.measured_vergence;
        self.measured_vergence = (low / ratio, high / ratio);
    }
}
