//! The commands, one a file; options that several share have files of their own.

mod apply;
mod choice;
mod demo;
mod diagnose;
mod drawing;
mod eval;
mod fit;
mod info;
mod lens;
mod lut;
mod picture;
mod plates;
mod psf;
mod relens;
mod removal;
mod remove;

pub use diagnose::self_test;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Parser, Subcommand};
use seidel_core::distance::ObjectDistance;
use seidel_core::field::ImagePoint;

use crate::Console;
use seidel_image_io::error::FileError;

/// Real lens blur, learned from measured point-spread functions.
#[derive(Debug, Parser)]
#[command(name = "seidel", version, about, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fit a lens and blur a plate on synthetic data
    Demo(demo::DemoArgs),
    /// Learn a lens from measured point-spread functions
    Fit(fit::FitArgs),
    /// Evaluate a lens on a set of point-spread functions
    Eval(eval::EvalArgs),
    /// Write the point-spread functions that a lens predicts
    Psf(psf::PsfArgs),
    /// Draw a lens profile, or print the schema of profiles
    #[command(subcommand)]
    Lens(lens::LensCommand),
    /// Blur a plate with a lens
    Apply(Box<apply::ApplyArgs>),
    /// Take a lens's blur off a plate
    Remove(Box<remove::RemoveArgs>),
    /// Give a plate the blur of another lens than the one it was taken with
    Relens(Box<relens::RelensArgs>),
    /// Describe image files and their provenance
    Info(info::InfoArgs),
    /// Convert pictures between colour spaces, or write look-up tables
    Lut(Box<lut::LutArgs>),
    /// Find the effects that a lens lacks against measured point-spread functions, and add them
    Diagnose(Box<diagnose::DiagnoseArgs>),
}

impl Command {
    /// Runs the command, which was called with `words`, the program's name first.
    ///
    /// # Errors
    /// Whatever stands in its way, in one message.
    pub fn run(self, words: &[OsString], console: &mut Console) -> Result<(), CommandError> {
        match self {
            Self::Demo(args) => demo::run(&args, console),
            Self::Fit(args) => fit::run(&args, console),
            Self::Eval(args) => eval::run(&args, console),
            Self::Psf(args) => psf::run(&args, console),
            Self::Lens(command) => lens::run(&command, console),
            Self::Apply(args) => apply::run(&args, words, console),
            Self::Remove(args) => remove::run(&args, words, console),
            Self::Relens(args) => relens::run(&args, words, console),
            Self::Info(args) => info::run(&args, console),
            Self::Lut(args) => lut::run(&args, words, console),
            Self::Diagnose(args) => diagnose::run(&args, console),
        }
    }
}

/// Why a command did not do its work.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// Something about a file.
    #[error(transparent)]
    File(#[from] FileError),
    /// Something about values that stand in no one file.
    #[error(transparent)]
    Core(#[from] seidel_core::Error),
    /// Some frames of a sequence, by their numbers; the others were rendered.
    #[error("{} of {count} frames failed:{}", failed.len(), frame_list(failed))]
    Frames {
        /// Each with its reason.
        failed: Vec<(i64, CommandError)>,
        /// Of how many.
        count: usize,
    },
    /// Options that do not go together: exit status 2.
    #[error("{0}")]
    Usage(String),
}

fn frame_list(failed: &[(i64, CommandError)]) -> String {
    let lines = failed
        .iter()
        .map(|(frame, why)| format!("\n  frame {frame}: {why}"));
    lines.collect()
}

/// The last component of a path, by which provenance names it.
fn short_name(path: &Path) -> String {
    let full = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let folder = match full.file_name() {
        // A manifest is known by its folder.
        Some(name) if name == "manifest.json" => full.parent().map(PathBuf::from),
        _ => Some(full.clone()),
    };
    folder
        .as_deref()
        .and_then(Path::file_name)
        .unwrap_or(full.as_os_str())
        .to_string_lossy()
        .into_owned()
}

/// Parses metres, or `inf`.
fn parse_distance(text: &str) -> Result<ObjectDistance, String> {
    let metres: f64 = text.parse().map_err(|_| "give metres, or inf".to_owned())?;
    ObjectDistance::metres(metres).map_err(|e| format!("{}; {}", e.problem, e.remedy))
}

/// Parses `X,Y` in frame pixels.
fn parse_point(text: &str) -> Result<ImagePoint, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let number = |t: &str| t.trim().parse::<f64>().ok().filter(|v| v.is_finite());
    match parts.as_slice() {
        [x, y] => match (number(x), number(y)) {
            (Some(x), Some(y)) => Ok(ImagePoint::new(x, y)),
            _ => Err("give two numbers in pixels, such as 960,540".to_owned()),
        },
        _ => Err("give x and y in pixels, such as 960,540".to_owned()),
    }
}
