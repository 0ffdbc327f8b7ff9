//! `seidel lens`: draws a lens profile, and prints the JSON schema of profiles.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use seidel_core::profile::schema;

use super::CommandError;
use super::drawing::{Drawing, DrawingArgs};
use crate::Console;
use crate::pictures::sheet::lens_sheet;
use seidel_image_io::png::write_rgb8;

/// The subcommands of `seidel lens`.
#[derive(Debug, Subcommand)]
pub enum LensCommand {
    /// Draw the PSFs of a lens over the frame, by channel and distance
    Show(ShowArgs),
    /// Print the JSON schema of lens profiles
    Schema,
}

/// Options of `seidel lens show`.
#[derive(Debug, Args)]
pub struct ShowArgs {
    /// Lens profile
    lens: PathBuf,
    /// Picture to write (PNG)
    #[arg(short, long, value_name = "SHEET.png")]
    output: PathBuf,
    #[command(flatten)]
    drawing: DrawingArgs,
}

pub(super) fn run(command: &LensCommand, console: &mut Console) -> Result<(), CommandError> {
    match command {
        LensCommand::Schema => {
            console.print(schema());
            Ok(())
        }
        LensCommand::Show(args) => show(args, console),
    }
}

fn show(args: &ShowArgs, console: &mut Console) -> Result<(), CommandError> {
    let Drawing { lens, model } = args.drawing.open(&args.lens, console)?;
    let sheet = lens_sheet(lens.profile(), model, &Default::default())?;
    write_rgb8(&args.output, &sheet)?;
    console.print(format!("wrote {}", args.output.display()));
    match lens.profile().adequacy() {
        Some(adequacy) => console.print(adequacy.to_string()),
        None => console.print("the profile does not say how well its model describes the lens"),
    }
    Ok(())
}
