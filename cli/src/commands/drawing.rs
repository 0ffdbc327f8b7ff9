//! Options of the commands that draw a lens: PSF model, focal length, focus, aperture and sensor shift.

use std::path::Path;

use clap::Args;
use seidel_core::{Lens, LensProfile, Settings};
use seidel_optics::psf;
use seidel_optics::psf::PsfModel;

use super::CommandError;
use super::knobs::LensKnobs;
use crate::Console;
use seidel_image_io::error::FileError;
use seidel_image_io::lens_profile;

/// Options that set a lens and choose its PSF model.
#[derive(Debug, Clone, Args)]
pub(super) struct DrawingArgs {
    #[command(flatten)]
    pub(super) knobs: LensKnobs,
    #[arg(long, help_heading = "Look", value_name = "MODEL", help = model_help())]
    psf: Option<String>,
}

/// Returns the help of `--psf`, which lists the models.
fn model_help() -> String {
    let names: Vec<_> = psf::ALL.iter().map(|model| model.id()).collect();
    format!(
        "PSF model: {}; the best for the lens if omitted",
        names.join(", ")
    )
}

/// A lens with its controls set, and the PSF model that draws it.
pub(super) struct Drawing {
    pub(super) lens: Lens,
    pub(super) model: &'static dyn PsfModel,
}

impl DrawingArgs {
    /// Reads the lens at `path`, sets its controls and chooses the PSF model.
    pub(super) fn open(&self, path: &Path, console: &mut Console) -> Result<Drawing, CommandError> {
        let mut settings = Settings::default();
        self.knobs.put(&mut settings)?;
        let mut warnings = Vec::new();
        let measured = lens_profile::read(path)?;
        let drawing = self.set(&measured, path, &settings, &mut warnings)?;
        for warning in warnings {
            console.note(warning);
        }
        Ok(drawing)
    }

    /// Sets the lens `measured`, read from the file `path`, to the controls of `settings`, and chooses the PSF model. Adds to
    /// `warnings`.
    pub(super) fn set(
        &self,
        measured: &LensProfile,
        path: &Path,
        settings: &Settings,
        warnings: &mut Vec<String>,
    ) -> Result<Drawing, CommandError> {
        let requested = self.psf.as_deref().map(psf::by_id).transpose()?;
        let controls = &settings.controls;
        let in_file = |e| FileError::from_core(path, e);
        let profile = measured.with_controls(controls).map_err(in_file)?;
        warnings.extend(measured.control_warnings(controls));
        let lens = Lens::new(profile).map_err(in_file)?;
        let model = requested.unwrap_or_else(|| lens.predictor().default_model());
        lens.predictor().check_model(model).map_err(in_file)?;
        Ok(Drawing { lens, model })
    }
}
