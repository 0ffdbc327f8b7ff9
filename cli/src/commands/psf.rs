//! `seidel psf`: the PSFs a lens predicts, as an observation set.

use std::path::PathBuf;

use clap::Args;
use seidel_core::predict::{Predictor, predict_like};
use seidel_core::psf;

use super::{CommandError, read_lens};
use crate::Console;
use crate::files::error::FileError;
use crate::files::manifest::{self, ReadOptions};

/// Options of `seidel psf`.
#[derive(Debug, Args)]
pub struct PsfArgs {
    /// The lens profile
    #[arg(long)]
    lens: PathBuf,
    /// Observation set whose positions, distances, sizes, channels and names to take
    #[arg(long, value_name = "OBS")]
    like: PathBuf,
    /// Folder to write the predicted set to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// PSF model: gaussian, skew-normal, skew-normal-general, skew-normal-eq43 or mirrored-pair
    #[arg(long, default_value = "skew-normal")]
    psf: String,
}

pub(super) fn run(args: &PsfArgs, console: &mut Console) -> Result<(), CommandError> {
    let lens = read_lens(&args.lens)?;
    let model = psf::by_id(&args.psf)?;
    let read = manifest::read(&args.like, ReadOptions::default())?;
    let predictor = Predictor::new(&lens)?;
    let predicted = predict_like(&predictor, &read.set, model)
        .map_err(|e| FileError::from_core(&args.like, e))?;
    manifest::write(&predicted, &args.out)?;
    console.say(format!(
        "wrote {} ({} observations)",
        args.out.display(),
        predicted.observations.len()
    ));
    Ok(())
}
