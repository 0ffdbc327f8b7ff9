//! The arguments that seidel_apply, seidel_remove and seidel_relens share.

use seidel_core::{Image, Progress};

use crate::callbacks::SeidelCallbacks;
use crate::image::{ImageView, SeidelImage, SeidelRect};
use crate::plate::{Plate, SeidelPlate};
use crate::pointers::{Versioned, read_optional};
use crate::settings::{SeidelSettings, Settings};
use crate::status::Result;
use crate::threads::run;

/// The arguments of a call that writes an image, lenses excepted.
pub(crate) struct CallArgs {
    pub(crate) settings: Settings,
    pub(crate) plate: Plate,
    pub(crate) output: ImageView,
    pub(crate) alphas: Option<ImageView>,
    callbacks: SeidelCallbacks,
}

impl CallArgs {
    /// Reads the arguments, and checks that the outputs fit the plate and the settings.
    ///
    /// # Safety
    /// Each pointer must be NULL or valid until the call ends.
    pub(crate) unsafe fn new(
        settings: *const SeidelSettings,
        plate: *const SeidelPlate,
        output: *const SeidelImage,
        alphas: *const SeidelImage,
        callbacks: *const SeidelCallbacks,
    ) -> Result<Self> {
        // SAFETY: as the caller guarantees.
        let args = unsafe {
            Self {
                settings: Settings::new(settings)?,
                plate: Plate::new(plate)?,
                output: ImageView::new(output, "output")?,
                alphas: ImageView::optional(alphas, "alphas")?,
                callbacks: read_optional(callbacks, "callbacks")?
                    .unwrap_or_else(SeidelCallbacks::defaults),
            }
        };
        (args.plate).check_outputs(&args.settings, &args.output, args.alphas.as_ref())?;
        Ok(args)
    }

    /// Does `work` on the library's threads, with the caller's thread limit and callbacks.
    pub(crate) fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Progress) -> Result<T> + Send + 'static,
    ) -> Result<T> {
        run(self.settings.raw.threads, &self.callbacks, work)
    }

    /// Writes `image`, which covers `rect`, to the caller's outputs.
    ///
    /// # Errors
    /// A sample that is too large for half floats, before anything is written.
    pub(crate) fn write(&self, image: &Image, rect: SeidelRect) -> Result<()> {
        let planes = image.colours.iter().chain(&image.alpha);
        for (channel, plane) in planes.enumerate().take(self.output.channels) {
            self.output.check_range(channel, rect, plane)?;
        }
        let planes = image.colours.iter().chain(&image.alpha);
        for (channel, plane) in planes.enumerate().take(self.output.channels) {
            self.output.write(channel, rect, plane);
        }
        let Some(alphas) = &self.alphas else {
            return Ok(());
        };
        let planes = image.channel_alphas.iter().enumerate();
        for (channel, plane) in planes.take(alphas.channels) {
            alphas.write(channel, rect, plane);
        }
        Ok(())
    }
}
