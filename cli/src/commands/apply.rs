//! `seidel apply`: blur a plate with a lens, pixel by pixel of field, channel and depth.

mod frame;
mod occlusion;
mod residual;
mod verbose;

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use seidel_core::{Edges, Quality, Settings};

use super::CommandError;
use super::plates::{DepthArgs, Files, LensArgs, PlateArgs, PlateReader, ReaderOptions, RunArgs};
use crate::Console;
use frame::Job;
use occlusion::OcclusionArgs;

/// Options of `seidel apply`.
#[derive(Debug, Args)]
pub struct ApplyArgs {
    /// The plate: OpenEXR, PNG, TIFF, DPX, Radiance HDR or JPEG; may hold a frame pattern such as plate.%04d.exr
    #[arg(value_name = "IN")]
    input: String,
    /// Where to write the blurred plate: EXR, PNG, TIFF, DPX or HDR by its extension. In the format of IN all else that
    /// the file holds is kept. Else EXR gets scene-linear, premultiplied colour: half of 8- and 10-bit and half-float
    /// samples, float of others; PNG the 8 bits of IN or 16; TIFF the 8 or 16 bits of IN or float; DPX 10 bits, or the
    /// 12 or 16 of IN, or 16 with alpha or without colour; HDR its shared exponents. Integers are sRGB-encoded unless
    /// --encoding says otherwise. What OUT cannot hold is told
    #[arg(short, long, value_name = "OUT")]
    output: String,
    /// The lens profile
    #[arg(long)]
    lens: PathBuf,
    #[command(flatten)]
    depth: DepthArgs,
    #[command(flatten)]
    occlusion: OcclusionArgs,
    #[command(flatten)]
    plate: PlateArgs,
    #[command(flatten)]
    lens_options: LensArgs,
    /// Light beyond the edges of the plate
    #[arg(long, value_enum, default_value_t = EdgeChoice::Mirror)]
    edges: EdgeChoice,
    /// How near to the exact renderer's result: draft (45 dB), final (60 dB, 75 dB where no blur is above 6 px; 50 dB
    /// for lenses drawn ray by ray) or exact
    #[arg(long, value_enum, default_value_t = QualityChoice::Final)]
    quality: QualityChoice,
    /// What `seidel remove --residual` wrote beside the plate IN: it is added where IN is as it was, so that the plate
    /// that it came from comes back there, and OUT has that plate's pixels only. May hold a frame pattern
    #[arg(long, value_name = "FILE")]
    residual: Option<String>,
    #[command(flatten)]
    run: RunArgs,
    /// Say of each frame how it was rendered, and how near that is to the exact renderer: measured at 64 pixels
    /// spread over the plate, as PSNR in dB of the plate's peak. Takes longer
    #[arg(long)]
    verbose: bool,
}

/// Accuracy of the render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum QualityChoice {
    /// For looking: 45 dB
    Draft,
    /// For delivery: 60 dB
    Final,
    /// Every source pixel with its own kernel: slow
    Exact,
}

impl From<QualityChoice> for Quality {
    fn from(choice: QualityChoice) -> Self {
        match choice {
            QualityChoice::Draft => Self::Draft,
            QualityChoice::Final => Self::Final,
            QualityChoice::Exact => Self::Exact,
        }
    }
}

/// Light beyond the edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EdgeChoice {
    /// The mirrored plate: no light is lost
    Mirror,
    /// Nothing: light that leaves is lost
    Black,
    /// The pixel nearest to it on the plate, with its depth and blur
    Extend,
}

impl ApplyArgs {
    /// The settings beside those of the lens by name, as in `default_rendering_record`.
    fn record(&self) -> [(String, String); 3] {
        let name = |value: Option<clap::builder::PossibleValue>| {
            value.map_or_else(String::new, |value| value.get_name().to_owned())
        };
        [
            ("quality".to_owned(), name(self.quality.to_possible_value())),
            ("edges".to_owned(), name(self.edges.to_possible_value())),
            ("occlusion".to_owned(), self.occlusion.record()),
        ]
    }
}

impl From<EdgeChoice> for Edges {
    fn from(choice: EdgeChoice) -> Self {
        match choice {
            EdgeChoice::Mirror => Self::Mirror,
            EdgeChoice::Black => Self::Black,
            EdgeChoice::Extend => Self::Extend,
        }
    }
}

pub(super) fn run(
    args: &ApplyArgs,
    words: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    args.plate.check_output(&args.output)?;
    let mut settings = Settings::default();
    settings.quality = args.quality.into();
    settings.edges = args.edges.into();
    settings.occlusion = args.occlusion.settings();
    let options = ReaderOptions {
        lens: &args.lens_options,
        depth: &args.depth,
        plate: &args.plate,
        output: &args.output,
    };
    let reader = PlateReader::open(&args.lens, &options, settings, console)?;
    let holdout = args.occlusion.source()?;
    let files = Files {
        input: &args.input,
        output: &args.output,
        read: (reader.depth_pattern().into_iter())
            .chain(holdout.file_patterns())
            .chain(args.residual.as_deref())
            .collect(),
        written: Vec::new(),
    };
    let frames = args.run.frames(&files, &[&args.lens], console)?;
    reader.check_animation(frames.iter().all(|frame| frame.number.is_some()))?;
    let made = (words, &[("Lens", args.lens.as_path())][..]);
    let run = args.run.begin("blurring", frames, made, console)?;
    let job = Job {
        args,
        reader: &reader,
        holdout: &holdout,
        run: &run,
    };
    run.through(&job, console)
}
