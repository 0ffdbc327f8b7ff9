//! `seidel measure`: from photographs to an observation set, one kind of photograph per file.

mod common;
mod edges;
mod fitted;
mod left_out;
mod lights;
mod photographs;

use clap::Subcommand;

use super::CommandError;
use crate::Console;
use crate::progress::ProgressArgs;

/// The kinds of photographs.
#[derive(Debug, Subcommand)]
pub enum MeasureCommand {
    /// Find point lights (pinholes, LEDs, stars) and cut a PSF tile around each
    Lights(Box<lights::LightsArgs>),
    /// Measure the blur across straight edges (dark squares, checkerboards) and fit a lens to it
    Edges(Box<edges::EdgesArgs>),
}

impl MeasureCommand {
    /// Returns the option about progress.
    pub(super) fn progress(&self) -> ProgressArgs {
        match self {
            Self::Lights(args) => args.common.progress,
            Self::Edges(args) => args.common.progress,
        }
    }
}

pub(super) fn run(command: &MeasureCommand, console: &mut Console) -> Result<(), CommandError> {
    match command {
        MeasureCommand::Lights(args) => lights::run(args, console),
        MeasureCommand::Edges(args) => edges::run(args, console),
    }
}
