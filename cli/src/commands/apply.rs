//! `seidel apply`: blurs a plate with a lens, by field position, channel and depth.

mod frame;
mod occlusion;
mod residual;
mod show;
mod verbose;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use seidel_core::{Edges, Expand, Quality, Settings};

use super::plates::{
    Files, LookArgs, LookUse, PlateCommandArgs, PlateReader, SettingsRecord, SideInputs, setting,
};
use super::{CommandError, value_name};
use crate::Console;
use crate::progress::ProgressArgs;
use frame::Job;
use occlusion::OcclusionArgs;
use show::ShowChoice;

/// Options of `seidel apply`.
#[derive(Debug, Args)]
pub struct ApplyArgs {
    /// Lens profile, or library:NAME
    #[arg(long, help_heading = "Input")]
    lens: PathBuf,
    #[command(flatten)]
    shared: PlateCommandArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    occlusion: OcclusionArgs,
    /// Light beyond the edges of the plate
    #[arg(long, value_enum, help_heading = "Output", default_value_t = EdgeChoice::Auto)]
    edges: EdgeChoice,
    /// Sides on which the data window grows by the reach of the blur, so that an element keeps its blurred rim (EXR only)
    #[arg(long, value_enum, help_heading = "Output", default_value_t = ExpandChoice::Auto)]
    expand: ExpandChoice,
    /// Accuracy of the render, as PSNR against the exact renderer
    #[arg(long, value_enum, help_heading = "Output", default_value_t = QualityChoice::Final)]
    quality: QualityChoice,
    /// Residual that `seidel remove --residual` wrote beside IN, or a frame pattern
    ///
    /// It is added where IN was not changed, which restores the original plate there. OUT has the pixels of that plate.
    #[arg(long, help_heading = "Input", value_name = "FILE")]
    residual: Option<PathBuf>,
    /// Picture of the blur by depth, instead of the plate
    #[arg(long, value_enum, help_heading = "Output", value_name = "PICTURE", conflicts_with_all = ["residual", "verbose"])]
    show: Option<ShowChoice>,
    /// Report the method and the accuracy of every render; takes longer
    ///
    /// Accuracy is the PSNR in dB of the plate's peak against the exact renderer, at 64 pixels spread over the plate.
    #[arg(long, help_heading = "Run")]
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
    /// By alpha: mirror for full frames, black for elements over nothing, extend for elements that the border cuts
    Auto,
    /// The mirrored plate: no light is lost
    Mirror,
    /// Black: light that leaves the plate is lost
    Black,
    /// The nearest pixel of the plate, with its depth and blur
    Extend,
}

impl EdgeChoice {
    /// Returns the chosen edges; `None` leaves the choice to the plate.
    fn edges(self) -> Option<Edges> {
        match self {
            Self::Auto => None,
            Self::Mirror => Some(Edges::Mirror),
            Self::Black => Some(Edges::Black),
            Self::Extend => Some(Edges::Extend),
        }
    }

    /// Returns the choice that stands for `edges`.
    fn of_edges(edges: Edges) -> Self {
        match edges {
            Edges::Mirror => Self::Mirror,
            Edges::Black => Self::Black,
            Edges::Extend => Self::Extend,
        }
    }
}

/// The sides on which the data window grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ExpandChoice {
    /// Sides beyond which nothing is known to be: those of a plate with alpha whose border is transparent or that lie
    /// within the display window
    Auto,
    /// All sides
    On,
    /// No side: light beyond the data window is cropped
    Off,
}

impl From<ExpandChoice> for Expand {
    fn from(choice: ExpandChoice) -> Self {
        match choice {
            ExpandChoice::Auto => Self::Auto,
            ExpandChoice::On => Self::Always,
            ExpandChoice::Off => Self::Never,
        }
    }
}

impl ApplyArgs {
    /// Returns the option about progress.
    pub(super) fn progress(&self) -> ProgressArgs {
        self.shared.run.progress
    }

    /// Returns the settings of a render with these `edges` by name, without those of lens and plate.
    fn record(&self, edges: Edges) -> SettingsRecord {
        let edges = EdgeChoice::of_edges(edges);
        rendering_record(self.quality, edges, &self.occlusion.record())
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
    settings.edges = args.edges.edges();
    settings.expand = args.expand.into();
    if args.residual.is_some() {
        // The residual is the rest of a render of the plate's own pixels with mirrored edges.
        settings.edges = settings.edges.or(Some(Edges::Mirror));
        settings.expand = Expand::Never;
    }
    settings.occlusion = args.occlusion.settings();
    let look = LookUse::ThisLens(&args.look);
    let reader = PlateReader::open(&args.lens, &args.shared, look, settings, console)?;
    args.occlusion.check()?;
    let files = Files {
        input: &args.shared.input,
        output: &args.shared.output,
        read: SideInputs {
            depth: args.shared.depth.depth.clone(),
            residual: args.residual.clone(),
            aperture_picture: args.look.files().next().map(Path::to_owned),
            ..args.occlusion.side_inputs()
        },
        written: Vec::new(),
        lenses: vec![("Lens", &args.lens)],
    };
    let task = if args.show.is_some() {
        "drawing"
    } else {
        "blurring"
    };
    let run = (args.shared.run).begin(task, &files, command_line, console)?;
    reader.check_animation(&run)?;
    let job = Job {
        args,
        reader: &reader,
        run: &run,
    };
    run.process(&job, console)
}
