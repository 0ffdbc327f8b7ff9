//! Options of the commands that draw a lens: PSF model, focal length, focus, aperture and sensor shift.

use std::path::Path;

use clap::Args;
use seidel_core::profile::{Controls, LensProfile};
use seidel_core::psf::{self, PsfModel};
use seidel_core::{Lens, ObjectDistance};

use super::{CommandError, parse_distance};
use crate::Console;
use seidel_image_io::error::FileError;
use seidel_image_io::lens_profile;

/// Options that set a lens and choose its PSF model.
#[derive(Debug, Clone, Args)]
pub(super) struct DrawingArgs {
    /// Focus distance, metres or `inf`; as measured if omitted
    ///
    /// Focus distance, f-number, focal length and sensor shift need a lens fitted with --model reduced or extended.
    #[arg(long, help_heading = "Focus", visible_alias = "focus-plane", value_name = "METRES", value_parser = parse_distance)]
    pub(super) focus_distance: Option<ObjectDistance>,
    /// F-number to stop the lens down to, such as 2.8 or f/2.8; as measured if omitted
    #[arg(long, help_heading = "Focus", value_name = "N", value_parser = parse_f_number)]
    pub(super) f_number: Option<f64>,
    /// Focal length to scale the lens to, millimetres: the lens and its frame grow in proportion; as measured if omitted
    ///
    /// The f-number and the focus distance stay. Blur is that of a lens of this focal length with the measured one's
    /// aberrations. See --film-back-mm.
    #[arg(long, help_heading = "Focus", value_name = "MM")]
    pub(super) focal_length_mm: Option<f64>,
    /// Shift of the sensor away from the lens, micrometres; negative towards it
    #[arg(long, help_heading = "Focus", value_name = "UM")]
    pub(super) sensor_shift_um: Option<f64>,
    #[arg(long, help_heading = "Look", value_name = "MODEL", help = model_help())]
    psf: Option<String>,
}

/// Parses an f-number, with or without `f/` before it.
fn parse_f_number(text: &str) -> Result<f64, String> {
    let lower = text.trim().to_ascii_lowercase();
    let number = lower.strip_prefix('f').unwrap_or(&lower);
    let number = number.strip_prefix('/').unwrap_or(number);
    number
        .trim()
        .parse()
        .map_err(|_| "give an f-number, such as 2.8 or f/2.8".to_owned())
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
        let mut warnings = Vec::new();
        let drawing = self.set(&lens_profile::read(path)?, path, &mut warnings)?;
        for warning in warnings {
            console.note(warning);
        }
        Ok(drawing)
    }

    /// Sets the controls of the lens `measured`, read from the file `path`, and chooses the PSF model. Adds to `warnings`.
    pub(super) fn set(
        &self,
        measured: &LensProfile,
        path: &Path,
        warnings: &mut Vec<String>,
    ) -> Result<Drawing, CommandError> {
        let requested = self.psf.as_deref().map(psf::by_id).transpose()?;
        let controls = Controls {
            focal_length_mm: self.focal_length_mm,
            focus_distance: self.focus_distance,
            f_number: self.f_number,
            sensor_shift_um: self.sensor_shift_um,
        };
        let in_file = |e| FileError::from_core(path, e);
        let profile = measured.with_controls(&controls).map_err(in_file)?;
        warnings.extend(measured.control_warnings(&controls));
        let lens = Lens::new(profile).map_err(in_file)?;
        let model = requested.unwrap_or_else(|| lens.predictor().default_model());
        lens.predictor().check_model(model).map_err(in_file)?;
        Ok(Drawing { lens, model })
    }
}
