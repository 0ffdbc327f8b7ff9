//! `seidel psf`: writes the PSFs that a lens predicts as an observation set.

use std::path::PathBuf;

use clap::Args;
use seidel_optics::predict::predict_set;

use super::CommandError;
use super::drawing::DrawingArgs;
use crate::Console;
use seidel_image_io::error::FileError;
use seidel_image_io::observation_set::{self as manifest, ReadOptions};

/// Options of `seidel psf`.
#[derive(Debug, Args)]
pub struct PsfArgs {
    /// Lens profile, or library:NAME
    #[arg(long)]
    lens: PathBuf,
    /// Observation set whose positions, distances, tile sizes, channels and file names to use
    #[arg(long, value_name = "OBS")]
    like: PathBuf,
    /// Folder to write the predicted set to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    drawing: DrawingArgs,
}

pub(super) fn run(args: &PsfArgs, console: &mut Console) -> Result<(), CommandError> {
    let drawing = args.drawing.open(&args.lens, console)?;
    let read = manifest::read(&args.like, ReadOptions::default())?;
    let predicted = predict_set(drawing.lens.predictor(), &read.set, drawing.model)
        .map_err(|e| FileError::from_core(&args.like, e))?;
    manifest::write(&predicted, &args.out)?;
    console.print(format!(
        "wrote {} ({} observations)",
        args.out.display(),
        predicted.observations.len()
    ));
    Ok(())
}
