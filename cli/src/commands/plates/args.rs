//! The options that all commands on plates share.

use std::path::PathBuf;

use clap::Args;
use seidel_image_io::formats::{names_read, names_written, written_samples};

use super::RunArgs;
use super::depth::DepthArgs;
use super::frame_lens::LensArgs;
use super::plate::PlateArgs;

/// The options that all commands on plates share.
#[derive(Debug, Args)]
pub(crate) struct PlateCommandArgs {
    #[arg(value_name = "IN", help = format!(
        "Plate to read: {}; or a frame pattern such as plate.%04d.exr", names_read()))]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) depth: DepthArgs,
    #[command(flatten)]
    pub(crate) lens: LensArgs,
    #[command(flatten)]
    pub(crate) plate: PlateArgs,
    #[arg(short, long, help_heading = "Output", value_name = "OUT",
        help = output_help(), long_help = output_long_help())]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Returns the short help of OUT.
fn output_help() -> String {
    let formats = names_written();
    format!("Plate to write: {formats} by its extension; or a frame pattern")
}

/// Returns the long help of OUT.
fn output_long_help() -> String {
    format!(
        "{}\n\nIn the format of IN, everything else in the file is kept. In another format: {} Integers are \
         sRGB-encoded unless --encoding says otherwise. Warnings name everything that OUT cannot store.",
        output_help(),
        written_samples()
    )
}
