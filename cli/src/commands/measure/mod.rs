//! `seidel measure`: from photographs to an observation set, one kind of photograph per file; charts and plans.

pub(super) mod camera;
mod chart;
pub(super) mod common;
mod edges;
pub(super) mod encoding;
mod faults;
mod fitted;
mod left_out;
mod light_size;
mod lights;
mod match_plate;
mod output;
mod pair;
pub(super) mod photographs;
mod plan;
mod print;

use std::ffi::OsString;

use clap::{Parser, Subcommand};

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
    /// Compare a printed or shown chart with its picture: PSFs block by block
    Chart(Box<chart::ChartArgs>),
    /// Compare a blurred photograph with a sharp one of the same scene from the same place
    Pair(Box<pair::PairArgs>),
    /// Match a lens to a plate of any content, from its own edges and lights, with how sure it is
    Match(Box<match_plate::MatchArgs>),
    /// Draw a chart to print or to show on a screen, sized for the expected blur
    Print(print::PrintArgs),
    /// Plan the photographs: distances, sizes of lights and charts, exposure
    Plan(plan::PlanArgs),
}

impl MeasureCommand {
    /// Returns the option about progress.
    pub(super) fn progress(&self) -> ProgressArgs {
        match self {
            Self::Lights(args) => args.common.input.progress,
            Self::Edges(args) => args.common.input.progress,
            Self::Chart(args) => args.common.input.progress,
            Self::Pair(args) => args.common.input.progress,
            Self::Match(args) => args.input.progress,
            Self::Print(_) | Self::Plan(_) => ProgressArgs::default(),
        }
    }
}

/// Names the option in place of the field at fault, which is called as it is.
fn by_option(mut error: seidel_core::Error) -> CommandError {
    if error.place != "sheet" {
        error.place = format!("--{}", error.place.replace('_', "-"));
    }
    error.into()
}

/// `seidel measure` and what follows it on a command line.
#[derive(Debug, Parser)]
struct MeasureLine {
    #[command(subcommand)]
    command: MeasureCommand,
}

/// Runs the command that a user would give as `seidel measure` and these `arguments`.
///
/// # Errors
/// Arguments that are not those of a command, and its errors.
pub(super) fn run_line(arguments: &[OsString], console: &mut Console) -> Result<(), CommandError> {
    let name = OsString::from("measure");
    let line = MeasureLine::try_parse_from(std::iter::once(&name).chain(arguments));
    let line = line.map_err(|error| CommandError::Usage(error.to_string()))?;
    run(&line.command, console)
}

pub(super) fn run(command: &MeasureCommand, console: &mut Console) -> Result<(), CommandError> {
    match command {
        MeasureCommand::Lights(args) => lights::run(args, console),
        MeasureCommand::Edges(args) => edges::run(args, console),
        MeasureCommand::Chart(args) => chart::run(args, console),
        MeasureCommand::Pair(args) => pair::run(args, console),
        MeasureCommand::Match(args) => match_plate::run(args, console),
        MeasureCommand::Print(args) => print::run(args, console),
        MeasureCommand::Plan(args) => plan::run(args, console),
    }
}
