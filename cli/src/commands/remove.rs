//! `seidel remove`: a plate without the blur of the lens that it was taken with.

mod extras;
mod frame;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use seidel_core::{Grain, RemovalSettings, Settings};

use super::CommandError;
use super::plates::{DepthArgs, Files, LensArgs, PlateArgs, PlateReader, ReaderOptions, RunArgs};
use super::removal::{LensCheck, RemovalArgs};
use crate::Console;
use frame::Job;
use seidel_image_io::format::{Format, check_output_name};

/// Options of `seidel remove`.
#[derive(Debug, Args)]
pub struct RemoveArgs {
    /// The plate: OpenEXR, PNG, TIFF, DPX, Radiance HDR or JPEG; may hold a frame pattern such as plate.%04d.exr
    #[arg(value_name = "IN")]
    input: String,
    /// Where to write the sharp plate: EXR, PNG, TIFF, DPX or HDR by its extension. In the format of IN all else that
    /// the file holds is kept. Else EXR gets scene-linear, premultiplied colour: half of 8- and 10-bit and half-float
    /// samples, float of others; PNG the 8 bits of IN or 16; TIFF the 8 or 16 bits of IN or float; DPX 10 bits, or the
    /// 12 or 16 of IN, or 16 with alpha or without colour; HDR its shared exponents. Integers are sRGB-encoded unless
    /// --encoding says otherwise. What OUT cannot hold is told
    #[arg(short, long, value_name = "OUT")]
    output: String,
    /// The profile of the lens that the plate was taken with
    #[arg(long)]
    lens: PathBuf,
    #[command(flatten)]
    removal: RemovalArgs,
    /// How much of the way from the plate to the sharp picture to go: 0 leaves the plate as it is
    #[arg(long, value_name = "S", default_value_t = 1.0, value_parser = parse_share)]
    strength: f64,
    /// What becomes of the plate's grain
    #[arg(long, value_enum, default_value_t = GrainChoice::Keep)]
    grain: GrainChoice,
    /// Write the plate's own pixels only. Otherwise the data window of an EXR written from
    /// EXR grows by what was found beyond the plate's
    /// edges, so that `seidel apply` gives the plate back right up to them
    #[arg(long)]
    no_overscan: bool,
    /// Write also what the plate has beside what the lens makes of OUT, which then has the format of IN, and a copy of
    /// OUT: with them `seidel apply
    /// --residual` gives back the plate where OUT was not worked on. OpenEXR; a frame pattern where OUT has one
    #[arg(long, value_name = "FILE")]
    residual: Option<String>,
    /// Write how much of each pixel was seen and not guessed, 0 to 1, a channel a colour. OpenEXR; a frame pattern where
    /// OUT has one
    #[arg(long, value_name = "FILE")]
    confidence: Option<String>,
    /// Write how many times its size in the plate noise has in the sharp picture, a channel a colour. OpenEXR; a frame
    /// pattern where OUT has one
    #[arg(long, value_name = "FILE")]
    noise_gain: Option<String>,
    #[command(flatten)]
    depth: DepthArgs,
    #[command(flatten)]
    plate: PlateArgs,
    #[command(flatten)]
    lens_options: LensArgs,
    #[command(flatten)]
    run: RunArgs,
}

/// Grain of the sharp image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum GrainChoice {
    /// The sharp picture gets the plate's own
    Keep,
    /// The sharp picture as it was solved for, nearly without
    Solved,
}

impl From<GrainChoice> for Grain {
    fn from(choice: GrainChoice) -> Self {
        match choice {
            GrainChoice::Keep => Self::Keep,
            GrainChoice::Solved => Self::Solved,
        }
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    number
        .filter(|v| (0.0..=1.0).contains(v))
        .ok_or_else(|| "give a number from 0 to 1".to_owned())
}

impl RemoveArgs {
    /// What is written beside the plate, each with its option.
    fn written(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let options = [
            ("--residual", &self.residual),
            ("--confidence", &self.confidence),
            ("--noise-gain", &self.noise_gain),
        ];
        let given = options.into_iter();
        given.filter_map(|(option, file)| Some((option, file.as_deref()?)))
    }
}

pub(super) fn run(
    args: &RemoveArgs,
    words: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    args.plate.check_output(&args.output)?;
    let mut settings = Settings::default();
    settings.removal = RemovalSettings {
        strength: args.strength,
        grain: args.grain.into(),
        ..args.removal.settings()
    };
    let options = ReaderOptions {
        lens: &args.lens_options,
        depth: &args.depth,
        plate: &args.plate,
        output: &args.output,
    };
    let reader = PlateReader::open(&args.lens, &options, settings, console)?;
    let files = Files {
        input: &args.input,
        output: &args.output,
        read: reader.depth_pattern().into_iter().collect(),
        written: args.written().collect(),
    };
    let frames = args.run.frames(&files, &[&args.lens], console)?;
    for path in frames.iter().flat_map(|frame| &frame.written) {
        check_output_name(path, Format::Exr)?;
    }
    reader.check_animation(frames.iter().all(|frame| frame.number.is_some()))?;
    let check = LensCheck::new(frames.len(), true);
    let made = (words, &[("Lens", args.lens.as_path())][..]);
    let run = args.run.begin("removing blur", frames, made, console)?;
    let job = Job {
        args,
        reader: &reader,
        check,
        run: &run,
    };
    run.through(&job, console)
}
