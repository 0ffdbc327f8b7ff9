//! How a lens is drawn: by which PSF model, and set to which focus and aperture.

use std::path::Path;

use clap::Args;
use seidel_core::distance::ObjectDistance;
use seidel_core::predict::Predictor;
use seidel_core::profile::{Controls, LensProfile};
use seidel_core::psf::{self, PsfModel};

use super::{CommandError, parse_distance, read_lens};
use crate::Console;
use seidel_image_io::error::FileError;

/// Options about how a lens is drawn.
#[derive(Debug, Clone, Args)]
pub(super) struct DrawingArgs {
    #[arg(long, value_name = "MODEL", help = model_help())]
    psf: Option<String>,
    /// Focus the lens at this distance, in metres, or `inf`; as measured if left out. Focus, f-number
    /// and sensor shift need a lens fitted with --model reduced
    #[arg(long, visible_alias = "focus-plane", value_name = "METRES", value_parser = parse_distance)]
    pub(super) focus_distance: Option<ObjectDistance>,
    /// Stop the lens down to this f-number; as measured if left out
    #[arg(long, value_name = "N")]
    pub(super) f_number: Option<f64>,
    /// Move the sensor away from the lens by this many micrometres; negative towards it
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    pub(super) sensor_shift_um: Option<f64>,
}

fn model_help() -> String {
    let names: Vec<_> = psf::ALL.iter().map(|model| model.id()).collect();
    format!(
        "PSF model: {}; what suits the lens best if left out",
        names.join(", ")
    )
}

/// A lens as it is to be drawn.
#[derive(Clone)]
pub(super) struct Drawing {
    /// The lens, its controls set.
    pub(super) lens: LensProfile,
    /// The same, ready to ask.
    pub(super) predictor: Predictor,
    /// The model to draw it with.
    pub(super) model: &'static dyn PsfModel,
}

impl DrawingArgs {
    /// Reads the lens at `path` and settles how to draw it.
    pub(super) fn open(&self, path: &Path, console: &mut Console) -> Result<Drawing, CommandError> {
        let mut said = Vec::new();
        let drawing = self.set(&read_lens(path)?, path, &mut said)?;
        for remark in said {
            console.remark(remark);
        }
        Ok(drawing)
    }

    /// Settles how to draw the lens that was `measured`, of the file `path`; remarks go to `said`.
    pub(super) fn set(
        &self,
        measured: &LensProfile,
        path: &Path,
        said: &mut Vec<String>,
    ) -> Result<Drawing, CommandError> {
        let named = self.psf.as_deref().map(psf::by_id).transpose()?;
        let controls = Controls {
            focus_distance: self.focus_distance,
            f_number: self.f_number,
            sensor_shift_um: self.sensor_shift_um,
        };
        let in_file = |e| FileError::from_core(path, e);
        let lens = measured.with_controls(&controls).map_err(in_file)?;
        said.extend(measured.control_warnings(&controls));
        let predictor = Predictor::new(&lens).map_err(in_file)?;
        let model = named.unwrap_or_else(|| predictor.default_model());
        predictor.check_model(model).map_err(in_file)?;
        Ok(Drawing {
            lens,
            predictor,
            model,
        })
    }
}
