//! The arguments of a call that renders, but for its lenses, read from the caller's memory.

use crate::callbacks::SeidelCallbacks;
use crate::image::{SeidelImage, View};
use crate::plate::{Plate, SeidelPlate};
use crate::pointers::{Sized64, maybe_sized};
use crate::settings::{SeidelSettings, Settings};
use crate::status::Result;

pub(crate) struct CallArgs {
    pub(crate) settings: Settings,
    pub(crate) plate: Plate,
    pub(crate) output: View,
    pub(crate) alphas: Option<View>,
    pub(crate) callbacks: SeidelCallbacks,
}

impl CallArgs {
    /// Reads the arguments, and checks that the outputs fit the plate and the settings.
    ///
    /// # Safety
    /// All must be NULL or good until the call ends.
    pub(crate) unsafe fn new(
        settings: *const SeidelSettings,
        plate: *const SeidelPlate,
        output: *const SeidelImage,
        alphas: *const SeidelImage,
        callbacks: *const SeidelCallbacks,
    ) -> Result<Self> {
        // SAFETY: as the caller vouches.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller vouches.
        let plate = unsafe { Plate::new(plate)? };
        // SAFETY: as the caller vouches.
        let (output, alphas) =
            unsafe { (View::new(output, "output")?, View::maybe(alphas, "alphas")?) };
        // SAFETY: as the caller vouches.
        let callbacks = unsafe { maybe_sized(callbacks, "callbacks")? };
        plate.check_outputs(&settings, &output, alphas.as_ref())?;
        Ok(Self {
            settings,
            plate,
            output,
            alphas,
            callbacks: callbacks.unwrap_or_else(SeidelCallbacks::neutral),
        })
    }
}
