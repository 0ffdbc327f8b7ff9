//! `seidel relens`: replaces the blur of the lens that a plate was taken with by that of another lens.

mod frame;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::Args;

use seidel_core::{Edges, RelensSide, Settings};

use super::CommandError;
use super::knobs::RelensKnobs;
use super::plates::{Files, LensUse, LookArgs, PlateCommandArgs, PlateReader, SideInputs};
use super::removal::{Removal, RemovalArgs, Task};
use crate::Console;
use crate::progress::ProgressArgs;
use frame::Job;

/// Options of `seidel relens`.
#[derive(Debug, Args)]
pub struct RelensArgs {
    /// Profile of the lens that the plate was taken with
    #[arg(long, help_heading = "Input", value_name = "LENS")]
    from: PathBuf,
    /// Profile of the lens whose blur the plate gets; that of --from if omitted
    ///
    /// Options about the lens apply to both lenses, but --from-... and --to-... to one of them: the lens of --from opened up is
    /// --from-f-number 4 --to-f-number 1.4.
    #[arg(long, help_heading = "Input", value_name = "LENS")]
    to: Option<PathBuf>,
    #[command(flatten)]
    sides: RelensKnobs,
    #[command(flatten)]
    shared: PlateCommandArgs,
    #[command(flatten)]
    look: LookArgs,
    #[command(flatten)]
    removal: RemovalArgs,
}

impl RelensArgs {
    /// Returns the option about progress.
    pub(super) fn progress(&self) -> ProgressArgs {
        self.shared.run.progress
    }
}

pub(super) fn run(
    args: &RelensArgs,
    command_line: &[OsString],
    console: &mut Console,
) -> Result<(), CommandError> {
    let mut settings = Settings::default();
    settings.edges = Some(Edges::Mirror);
    settings.removal = args.removal.settings();
    args.sides.put(&mut settings)?;
    let (shared, look) = (&args.shared, &args.look);
    let to_lens = args.to.as_ref().unwrap_or(&args.from);
    let side = |side| LensUse::Relens(side, look, &args.sides);
    let from_use = side(RelensSide::From);
    let mut from = PlateReader::open(&args.from, shared, from_use, settings.clone(), console)?;
    let mut to = PlateReader::open(to_lens, shared, side(RelensSide::To), settings, console)?;
    let files = Files {
        input: &args.shared.input,
        output: &args.shared.output,
        read: SideInputs {
            depth: shared.depth.depth.clone(),
            aperture_picture: look.files().next().map(Path::to_owned),
            ..SideInputs::default()
        },
        written: Vec::new(),
        lenses: (shared.lens).files_with(vec![("FromLens", &args.from), ("ToLens", to_lens)]),
    };
    let run = (args.shared.run).begin("changing lenses", &files, command_line, console)?;
    from.begin(&run, console)?;
    to.begin_beside(&from, console)?;
    let removal = Removal::new(&args.removal, &from, &run, Task::Relens);
    run.process(&Job { removal, to: &to }, console)
}
