//! `seidel relens`: a plate taken with one lens as another would have drawn it.

mod frame;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::Args;

use seidel_core::Settings;

use super::CommandError;
use super::plates::{DepthArgs, Files, LensArgs, PlateArgs, PlateReader, ReaderOptions, RunArgs};
use super::removal::{LensCheck, RemovalArgs};
use crate::Console;
use frame::Job;

/// Options of `seidel relens`.
#[derive(Debug, Args)]
pub struct RelensArgs {
    /// The plate: OpenEXR, PNG, TIFF, DPX, Radiance HDR or JPEG; may hold a frame pattern such as plate.%04d.exr
    #[arg(value_name = "IN")]
    input: String,
    /// Where to write the plate as the other lens draws it: EXR, PNG, TIFF, DPX or HDR by its extension. In the format
    /// of IN all else that the file holds is kept. Else EXR gets scene-linear, premultiplied colour: half of 8- and
    /// 10-bit and half-float samples, float of others; PNG the 8 bits of IN or 16; TIFF the 8 or 16 bits of IN or
    /// float; DPX 10 bits, or the 12 or 16 of IN, or 16 with alpha or without colour; HDR its shared exponents.
    /// Integers are sRGB-encoded unless --encoding says otherwise. What OUT cannot hold is told
    #[arg(short, long, value_name = "OUT")]
    output: String,
    /// The profile of the lens that the plate was taken with. Options about the lens go for both
    #[arg(long, value_name = "LENS")]
    from: PathBuf,
    /// The profile of the lens that the plate is to look like
    #[arg(long, value_name = "LENS")]
    to: PathBuf,
    #[command(flatten)]
    removal: RemovalArgs,
    #[command(flatten)]
    depth: DepthArgs,
    #[command(flatten)]
    plate: PlateArgs,
    #[command(flatten)]
    lens_options: LensArgs,
    #[command(flatten)]
    run: RunArgs,
}

pub(super) fn run(
    args: &RelensArgs,
    words: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    args.plate.check_output(&args.output)?;
    let mut settings = Settings::default();
    settings.removal = args.removal.settings();
    let options = ReaderOptions {
        lens: &args.lens_options,
        depth: &args.depth,
        plate: &args.plate,
        output: &args.output,
    };
    let from = PlateReader::open(&args.from, &options, settings.clone(), console)?;
    let to = PlateReader::open(&args.to, &options, settings, console)?;
    let files = Files {
        input: &args.input,
        output: &args.output,
        read: from.depth_pattern().into_iter().collect(),
        written: Vec::new(),
    };
    let frames = args.run.frames(&files, &[&args.from, &args.to], console)?;
    from.check_animation(frames.iter().all(|frame| frame.number.is_some()))?;
    let check = LensCheck::new(frames.len(), false);
    let lenses: [(&str, &Path); 2] = [("FromLens", &args.from), ("ToLens", &args.to)];
    let run = (args.run).begin("changing lenses", frames, (words, &lenses), console)?;
    let job = Job {
        args,
        from: &from,
        to: &to,
        check,
        run: &run,
    };
    run.through(&job, console)
}
