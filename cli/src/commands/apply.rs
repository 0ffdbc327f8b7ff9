//! `seidel apply`: blurs a plate with a lens, by field position, channel and depth.

mod frame;
mod occlusion;
mod residual;
mod verbose;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use seidel_core::{Edges, Quality, Settings};

use super::plates::{Files, PlateCommandArgs, PlateReader, SettingsRecord, setting};
use super::{CommandError, value_name};
use crate::Console;
use frame::Job;
use occlusion::OcclusionArgs;

/// Options of `seidel apply`.
#[derive(Debug, Args)]
pub struct ApplyArgs {
    /// Lens profile
    #[arg(long)]
    lens: PathBuf,
    #[command(flatten)]
    shared: PlateCommandArgs,
    #[command(flatten)]
    occlusion: OcclusionArgs,
    /// Light beyond the edges of the plate
    #[arg(long, value_enum, default_value_t = EdgeChoice::Mirror)]
    edges: EdgeChoice,
    /// Accuracy of the render, as PSNR against the exact renderer
    #[arg(long, value_enum, default_value_t = QualityChoice::Final)]
    quality: QualityChoice,
    /// Residual that `seidel remove --residual` wrote beside IN, or a frame pattern
    ///
    /// It is added where IN was not changed, which restores the original plate there. OUT has the pixels of that plate.
    #[arg(long, value_name = "FILE")]
    residual: Option<PathBuf>,
    /// Report the method and the accuracy of every render; takes longer
    ///
    /// Accuracy is the PSNR in dB of the plate's peak against the exact renderer, at 64 pixels spread over the plate.
    #[arg(long)]
    verbose: bool,
}

/// The accuracy of the render.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum QualityChoice {
    /// For previews: 45 dB
    Draft,
    /// For delivery: 60 dB, 75 dB where no blur is above 6 px, 50 dB for lenses modelled ray by ray
    Final,
    /// A kernel of its own for every source pixel: slow
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

/// The light beyond the edges of the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EdgeChoice {
    /// The mirrored plate: no light is lost
    Mirror,
    /// Black: light that leaves the plate is lost
    Black,
    /// The nearest pixel of the plate, with its depth and blur
    Extend,
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

impl ApplyArgs {
    /// Returns the settings of the render by name, without those of lens and plate.
    fn record(&self) -> SettingsRecord {
        rendering_record(self.quality, self.edges, &self.occlusion.record())
    }
}

fn rendering_record(quality: QualityChoice, edges: EdgeChoice, occlusion: &str) -> SettingsRecord {
    vec![
        setting("quality", value_name(quality)),
        setting("edges", value_name(edges)),
        setting("occlusion", occlusion),
    ]
}

/// Returns the settings of a render by name with all options of `apply` at their defaults, without those of lens and
/// plate.
pub(super) fn default_rendering_record() -> SettingsRecord {
    rendering_record(QualityChoice::Final, EdgeChoice::Mirror, "on")
}

pub(super) fn run(
    args: &ApplyArgs,
    command_line: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    let mut settings = Settings::default();
    settings.quality = args.quality.into();
    settings.edges = args.edges.into();
    settings.occlusion = args.occlusion.settings();
    let reader = PlateReader::open(&args.lens, &args.shared, settings, console)?;
    let holdout = args.occlusion.holdout()?;
    let files = Files {
        input: &args.shared.input,
        output: &args.shared.output,
        read: (reader.depth_pattern().into_iter())
            .chain(holdout.file_patterns())
            .map(Path::new)
            .chain(args.residual.as_deref())
            .collect(),
        written: Vec::new(),
        lenses: vec![("Lens", &args.lens)],
    };
    let run = (args.shared.run).begin("blurring", &files, command_line, console)?;
    reader.check_animation(&run)?;
    let job = Job {
        args,
        reader: &reader,
        holdout: &holdout,
        run: &run,
    };
    run.process(&job, console)
}
