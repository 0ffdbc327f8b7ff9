//! `seidel remove`: removes the blur of the lens that a plate was taken with.

mod frame;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::NonEmptyStringValueParser;

use seidel_core::{Edges, Settings};

use super::CommandError;
use super::knobs::RemoveKnobs;
use super::plates::{Files, LensUse, PlateCommandArgs, PlateReader, SideInputs, channel_parser};
use super::removal::{Removal, RemovalArgs, Task};
use crate::Console;
use crate::progress::ProgressArgs;
use frame::Job;
use seidel_image_io::formats::exr;
use seidel_image_io::image_channel::ChannelSpec;

/// Options of `seidel remove`.
#[derive(Debug, Args)]
pub struct RemoveArgs {
    /// Profile of the lens that the plate was taken with
    #[arg(long, help_heading = "Input")]
    lens: PathBuf,
    #[command(flatten)]
    shared: PlateCommandArgs,
    /// The plate without its foreground (a clean plate), through the same lens, or a frame pattern: blur is removed from the
    /// edges of the foreground too, which keep theirs otherwise
    ///
    /// Its depth is its own Z channel or --background-depth, with the meaning of the plate's.
    #[arg(long, help_heading = "Depth", value_name = "FILE", conflicts_with = "only_chroma", value_parser = NonEmptyStringValueParser::new())]
    background: Option<String>,
    /// Depth pass of the background, or a frame pattern
    #[arg(long, help_heading = "Depth", value_name = "FILE[:CHANNEL]", requires = "background", value_parser = channel_parser())]
    background_depth: Option<ChannelSpec>,
    #[command(flatten)]
    removal: RemovalArgs,
    #[command(flatten)]
    knobs: RemoveKnobs,
    /// Take off colour fringes only: give each colour the blur of the colour whose blur is of middle size
    ///
    /// Lateral and axial colour go; the plate does not become sharper. The lens is not checked.
    #[arg(long, help_heading = "Look", conflicts_with_all = ["residual", "confidence", "noise_gain", "grain", "lens_check"])]
    only_chroma: bool,
    /// Write the plate's own pixels only
    ///
    /// Otherwise the data window of an EXR written from EXR grows by the light found beyond the plate's edges. `seidel
    /// apply` then restores the plate up to its edges.
    #[arg(long, help_heading = "Output")]
    no_overscan: bool,
    /// Residual to write: the plate minus the re-blurred OUT, and a copy of OUT (OpenEXR; a frame pattern if OUT is one)
    ///
    /// With it, `seidel apply --residual` restores the plate where OUT was not changed. OUT must have the format of IN.
    #[arg(long, help_heading = "Output", value_name = "FILE")]
    residual: Option<PathBuf>,
    /// Confidence map to write: the share of each pixel's detail that the plate determines, 0 to 1, one channel per colour
    /// (OpenEXR; a frame pattern if OUT is one)
    #[arg(long, help_heading = "Output", value_name = "FILE")]
    confidence: Option<PathBuf>,
    /// Map of the amplification of noise to write, one channel per colour (OpenEXR; a frame pattern if OUT is one)
    #[arg(long, help_heading = "Output", value_name = "FILE")]
    noise_gain: Option<PathBuf>,
}

impl RemoveArgs {
    /// Returns the files to write beside the plate, each with its option.
    fn side_files(&self) -> Vec<(&'static str, &Path)> {
        let options = [
            ("--residual", &self.residual),
            ("--confidence", &self.confidence),
            ("--noise-gain", &self.noise_gain),
        ];
        let options = options.into_iter();
        let used = options.filter_map(|(option, file)| Some((option, file.as_deref()?)));
        used.collect()
    }
}

impl RemoveArgs {
    /// Returns the option about progress.
    pub(super) fn progress(&self) -> ProgressArgs {
        self.shared.run.progress
    }
}

pub(super) fn run(
    args: &RemoveArgs,
    command_line: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    let mut settings = Settings::default();
    // Those of the removal itself, which the residual is measured against.
    settings.edges = Some(Edges::Mirror);
    settings.removal = args.removal.settings();
    args.knobs.put(&mut settings)?;
    let mut reader =
        PlateReader::open(&args.lens, &args.shared, LensUse::Remove, settings, console)?;
    let files = Files {
        input: &args.shared.input,
        output: &args.shared.output,
        read: SideInputs {
            depth: args.shared.depth.depth.clone(),
            background: args.background.as_ref().map(PathBuf::from),
            background_depth: args.background_depth.clone(),
            ..SideInputs::default()
        },
        written: args.side_files(),
        lenses: (args.shared.lens).files_with(vec![("Lens", &args.lens)]),
    };
    let run = (args.shared.run).begin("removing blur", &files, command_line, console)?;
    for (_, path) in run.frames().iter().flat_map(|frame| &frame.written) {
        exr::FORMAT.check_name(path)?;
    }
    reader.begin(&run, console)?;
    let removal = Removal::new(&args.removal, &reader, &run, Task::Remove);
    run.process(&Job { args, removal }, console)
}
