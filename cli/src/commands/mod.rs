//! The commands, one per file, and the options that several commands share.

mod apply;
mod choice;
mod completions;
mod demo;
mod diagnose;
mod drawing;
mod eval;
mod fit;
mod help;
mod info;
mod knobs;
mod lens;
mod lut;
mod man;
mod measure;
#[cfg(test)]
mod options_page;
mod picture;
mod plates;
mod psf;
mod relens;
mod removal;
mod remove;
mod suggestion;
mod tile_moments;
mod view;

pub use help::command;
pub(crate) use suggestion::suggest_by_meaning;

use std::ffi::OsString;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Parser, Subcommand, ValueEnum};
use rayon::{ThreadPool, ThreadPoolBuilder};
use seidel_core::diagnosis::Bookkeeping;
use seidel_core::{ImagePoint, ObjectDistance};

use crate::Console;
use crate::progress::ProgressForm;
use seidel_image_io::atomic::write_atomically;
use seidel_image_io::error::FileError;
use seidel_image_io::samples::Encoding;

/// Real lens blur, learned from measured point-spread functions.
#[derive(Debug, Parser)]
#[command(name = "seidel", version, about, max_term_width = 100)]
pub struct Cli {
    /// The command
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Measure, fit, apply, diagnose and correct a lens on synthetic data
    Demo(demo::DemoArgs),
    /// Measure point-spread functions in photographs
    #[command(subcommand)]
    Measure(measure::MeasureCommand),
    /// Fit a lens to measured point-spread functions
    Fit(fit::FitArgs),
    /// Evaluate a lens on a set of point-spread functions
    Eval(eval::EvalArgs),
    /// Write the point-spread functions that a lens predicts
    Psf(psf::PsfArgs),
    /// List and describe the lenses of the library, draw a lens, or print the schema of profiles
    #[command(subcommand)]
    Lens(lens::LensCommand),
    /// Write a page on which a lens, a set or a diagnosis is looked at in the browser
    View(view::ViewArgs),
    /// Blur a plate with a lens
    Apply(Box<apply::ApplyArgs>),
    /// Remove the blur of a lens from a plate
    Remove(Box<remove::RemoveArgs>),
    /// Replace the blur of the lens that a plate was taken with by that of another
    Relens(Box<relens::RelensArgs>),
    /// Describe image files and their provenance
    Info(info::InfoArgs),
    /// Convert pictures between colour spaces, or write look-up tables
    Lut(Box<lut::LutArgs>),
    /// Find the effects that a lens lacks against measured point-spread functions, and add them
    Diagnose(Box<diagnose::DiagnoseArgs>),
    /// Print a script that completes commands and options in a shell
    Completions(completions::CompletionsArgs),
    /// Write manual pages
    Man(man::ManArgs),
}

impl Command {
    /// Runs the command. `command_line` goes into the provenance of outputs, program name first. The `note` about defaults is
    /// printed in the form of progress of the command.
    ///
    /// # Errors
    /// The reason why the command failed, as one message.
    pub fn run(
        self,
        command_line: &[OsString],
        note: Option<&str>,
        console: &mut Console,
    ) -> Result<(), CommandError> {
        console.set_progress_form(self.progress_form());
        if let Some(note) = note {
            console.note(note);
        }
        match self {
            Self::Demo(args) => demo::run(&args, command_line, console),
            Self::Measure(command) => measure::run(&command, console),
            Self::Fit(args) => fit::run(&args, console),
            Self::Eval(args) => eval::run(&args, console),
            Self::Psf(args) => psf::run(&args, console),
            Self::Lens(command) => lens::run(&command, console),
            Self::View(args) => view::run(&args, console),
            Self::Apply(args) => apply::run(&args, command_line, console),
            Self::Remove(args) => remove::run(&args, command_line, console),
            Self::Relens(args) => relens::run(&args, command_line, console),
            Self::Info(args) => info::run(&args, console),
            Self::Lut(args) => lut::run(&args, command_line, console),
            Self::Diagnose(args) => diagnose::run(&args, console),
            Self::Completions(args) => completions::run(&args, console),
            Self::Man(args) => man::run(&args, console),
        }
    }

    /// Returns the form of progress that the command line asks for.
    fn progress_form(&self) -> ProgressForm {
        let args = match self {
            Self::Demo(args) => args.progress,
            Self::Measure(command) => command.progress(),
            Self::Fit(args) => args.progress,
            Self::Eval(args) => args.progress,
            Self::Apply(args) => args.progress(),
            Self::Remove(args) => args.progress(),
            Self::Relens(args) => args.progress(),
            Self::Lut(args) => args.progress(),
            Self::Diagnose(args) => args.progress,
            Self::Psf(_)
            | Self::View(_)
            | Self::Lens(_)
            | Self::Info(_)
            | Self::Completions(_)
            | Self::Man(_) => {
                return ProgressForm::Auto;
            }
        };
        args.form()
    }
}

/// The reason why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// A fault of a file.
    #[error(transparent)]
    File(#[from] FileError),
    /// A fault of values that belong to no single file.
    #[error(transparent)]
    Core(#[from] seidel_core::Error),
    /// Failed frames of a sequence; the others were rendered.
    #[error("{} of {count} frames failed:{}", failed.len(), frame_list(failed))]
    Frames {
        /// Numbers of the frames, each with its error.
        failed: Vec<(i64, CommandError)>,
        /// Number of frames in the run.
        count: usize,
    },
    /// Options that cannot be combined: exit status 2.
    #[error("{0}")]
    Usage(String),
}

fn frame_list(failed: &[(i64, CommandError)]) -> String {
    let lines = failed
        .iter()
        .map(|(frame, error)| format!("\n  frame {frame}: {error}"));
    lines.collect()
}

/// Returns a note on a mistake in the books of a set that was looked for without a diagnosis.
fn mistake_note(found: &Bookkeeping) -> String {
    let changes = match found.gap_after < found.gap_before {
        true => format!(
            " With that corrected the gap of a PSF falls from {:.1} % to {:.1} %.",
            100.0 * found.gap_before,
            100.0 * found.gap_after.max(0.0)
        ),
        false => String::new(),
    };
    format!(
        "the books of the set may hold a mistake: {}.{changes} {}",
        found.words, found.remedy
    )
}

/// Returns the last component of a path, by which provenance names the file.
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

/// Returns the name of `value` on the command line.
fn value_name(value: impl ValueEnum) -> String {
    let name = value.to_possible_value();
    name.map_or_else(String::new, |name| name.get_name().to_owned())
}

/// Writes `text` to a file, whole or not at all.
fn write_text(path: &Path, text: &str) -> Result<(), FileError> {
    write_atomically(path, |out| out.write_all(text.as_bytes()))
}

/// Largest number of threads. More than this take longer to start and to synchronise than any machine gains by them.
const MAX_THREADS: usize = 1024;

/// Parses a number of threads; 0 is one per core.
fn parse_threads(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|count| *count <= MAX_THREADS);
    number.ok_or_else(|| {
        format!("give a number from 1 to {MAX_THREADS}, or leave it out for one per core")
    })
}

/// Returns a pool of as many threads as `--threads` says, or one per core.
fn thread_pool(threads: Option<usize>) -> Result<ThreadPool, CommandError> {
    ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|e| CommandError::Usage(format!("--threads: {e}")))
}

/// The encoding of integer samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EncodingChoice {
    /// Proportional to light
    Linear,
    /// The sRGB transfer function
    Srgb,
}

impl From<EncodingChoice> for Encoding {
    fn from(choice: EncodingChoice) -> Self {
        match choice {
            EncodingChoice::Linear => Self::Linear,
            EncodingChoice::Srgb => Self::Srgb,
        }
    }
}

/// Parses metres, or `inf`.
fn parse_distance(text: &str) -> Result<ObjectDistance, String> {
    let metres: f64 = text.parse().map_err(|_| "give metres, or inf".to_owned())?;
    // `null` is infinity in JSON.
    ObjectDistance::metres(metres)
        .map_err(|e| format!("{}; {}", e.problem, e.remedy.replace("null", "inf")))
}

/// Parses `X,Y` in frame pixels.
fn parse_point(text: &str) -> Result<ImagePoint, String> {
    let number = |text: &str| text.trim().parse().ok().filter(|v: &f64| v.is_finite());
    let point = text.split_once(',').and_then(|(x, y)| {
        let (x_px, y_px) = (number(x)?, number(y)?);
        Some(ImagePoint::new(x_px, y_px))
    });
    point.ok_or_else(|| "give x and y in pixels, such as 960,540".to_owned())
}
