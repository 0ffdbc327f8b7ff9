//! A run over a single plate or the frames of a sequence.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde_json::json;

use super::finished_frame::FinishedFrame;
use super::frames::{Files, FrameFiles};
use super::memory::{DEFAULT_MEMORY, parse_size};
use super::queue::{FrameResult, Resources, run_pipeline};
use super::resume::unfinished;
use super::views::{AllViews, ViewWork};
use crate::Console;
use crate::commands::{CommandError, parse_threads, thread_pool};
use crate::progress::{ProgressArgs, ProgressBar};
use seidel_image_io::provenance::{Provenance, ProvenancePaths};
use seidel_image_io::sequence::{FramePattern, expand_frames, gaps};

/// Options about frames, threads, memory and provenance.
#[derive(Debug, Args)]
#[command(next_help_heading = "Run")]
pub(crate) struct RunArgs {
    /// Frames to process if IN and OUT are frame patterns, such as 1001-1100, 1-9x2 or -3-3; all frames of IN on disk if omitted
    #[arg(long, allow_hyphen_values = true)]
    frames: Option<String>,
    /// Number of threads; all cores if omitted
    #[arg(long, value_parser = parse_threads)]
    threads: Option<usize>,
    /// Memory for the frames in flight, such as 500M or 4G; a frame that may take more is rendered alone, with a note
    #[arg(long, value_name = "SIZE", default_value = DEFAULT_MEMORY, value_parser = parse_size)]
    memory: u64,
    /// Keep outputs of the same lens and options; otherwise OUT is overwritten
    ///
    /// Options and lens are known by the provenance that outputs of every format hold. Files that do not say what made them are
    /// rendered again, with a note. With --provenance none every image of the name is kept, with a note.
    #[arg(long)]
    skip_existing: bool,
    /// Version, command, lens and settings in the metadata of OUT, where `seidel info` shows them
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = ProvenanceChoice::Names)]
    provenance: ProvenanceChoice,
    /// The same as --provenance none
    #[arg(long, conflicts_with = "provenance")]
    no_provenance: bool,
    /// File of defaults for options that are not given: seidel.toml in the working folder or above it if omitted; none for none
    ///
    /// Its keys are long options; those in a section such as [apply] are of that command alone.
    #[arg(long, value_name = "FILE")]
    defaults: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) progress: ProgressArgs,
}

/// The provenance in the metadata of outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ProvenanceChoice {
    /// With paths as on the command line
    Full,
    /// With the names of files alone, without their folders, also in the history that IN holds
    Names,
    /// Nothing is added
    None,
}

impl RunArgs {
    /// Returns the name of an option about the outputs of plates, if one is used.
    pub(crate) fn plate_option(&self) -> Option<&'static str> {
        match self {
            _ if self.frames.is_some() => Some("--frames"),
            _ if self.skip_existing => Some("--skip-existing"),
            _ => None,
        }
    }

    /// Prepares a run over `files`; `label` names it on the progress bar, `command_line` goes into the provenance. Prints
    /// a note if frames are skipped.
    ///
    /// # Errors
    /// Frame patterns that do not match `--frames`, outputs that cannot be written or would replace an input, and lens
    /// profiles that cannot be read.
    pub(crate) fn begin(
        &self,
        label: &str,
        files: &Files,
        command_line: &[OsString],
        console: &mut Console,
    ) -> Result<Run, CommandError> {
        let mut frames = self.expand(files)?;
        if self.frames.is_none() {
            let numbers: Vec<i64> = frames.iter().filter_map(|frame| frame.number).collect();
            if let (Some(first), Some(last)) = (numbers.first(), numbers.last()) {
                let missing = gaps(&numbers);
                let missing = missing.map_or_else(String::new, |gaps| format!("; missing: {gaps}"));
                let count = numbers.len();
                console.note(format!(
                    "{count} frames on disk, {first} to {last}{missing}"
                ));
            }
        }
        let mut provenance = Provenance::new(command_line);
        for (role, path) in &files.lenses {
            provenance = provenance.with_file(role, path)?;
        }
        let provenance = match self.provenance {
            _ if self.no_provenance => None,
            ProvenanceChoice::None => None,
            ProvenanceChoice::Names => Some(provenance.with_paths(ProvenancePaths::Names)),
            ProvenanceChoice::Full => Some(provenance),
        };
        let inputs = frames.iter();
        let inputs = inputs.map(|frame| (frame.number, frame.input.clone()));
        let inputs: Vec<(Option<i64>, PathBuf)> = inputs.collect();
        if self.skip_existing {
            frames = unfinished(frames, provenance.as_ref(), console);
        }
        Ok(Run {
            resources: Resources {
                reading: thread_pool(self.threads)?,
                processing: thread_pool(self.threads)?,
                memory: self.memory,
            },
            bar: console.progress_bar(label),
            provenance,
            frames,
            inputs,
        })
    }

    /// Returns the files of every frame, checked.
    fn expand(&self, files: &Files) -> Result<Vec<FrameFiles>, CommandError> {
        let read = files.read.paths();
        let mut patterns = vec![files.input, files.output];
        patterns.extend(read.iter().map(PathBuf::as_path));
        patterns.extend(files.written.iter().map(|(_, pattern)| pattern));
        let numbers = expand_frames(&patterns, self.frames.as_deref())?;
        if numbers.len() > 1 {
            for (option, pattern) in &files.written {
                if !FramePattern::parse(pattern).has_frame() {
                    return Err(CommandError::Usage(format!(
                        "{option} needs a frame pattern as -o has one, such as name.%04d.exr"
                    )));
                }
            }
        }
        let frames = numbers.into_iter().map(|number| files.at_frame(number));
        let frames: Vec<FrameFiles> = frames.collect();
        for frame in &frames {
            frame.check(&files.lenses)?;
        }
        Ok(frames)
    }
}

/// A run: its frames, and the threads, memory and progress bar that they share.
pub(crate) struct Run {
    frames: Vec<FrameFiles>,
    /// Number and plate of every frame, those that an earlier run finished among them.
    inputs: Vec<(Option<i64>, PathBuf)>,
    resources: Resources,
    bar: ProgressBar,
    provenance: Option<Provenance>,
}

impl Run {
    /// Returns the files of all frames.
    pub(crate) fn frames(&self) -> &[FrameFiles] {
        &self.frames
    }

    /// Returns number and plate of every frame, those that an earlier run finished among them.
    pub(super) fn inputs(&self) -> &[(Option<i64>, PathBuf)] {
        &self.inputs
    }

    /// Returns the memory for the frames in flight, bytes.
    pub(crate) fn memory_bytes(&self) -> u64 {
        self.resources.memory
    }

    /// Returns whether all frames have a number.
    pub(crate) fn is_sequence(&self) -> bool {
        self.frames.iter().all(|frame| frame.number.is_some())
    }

    /// Shows that `share` (0 to 1) of the work on the frame at `index` is done. Always returns true, as
    /// [`ProgressBar::show`] does.
    pub(crate) fn show_progress(&self, index: usize, share: f64) -> bool {
        (self.bar).show((index as f64 + share) / self.frames.len() as f64)
    }

    /// Writes all files of the frame at `index`, with provenance unless it is off. Returns warnings.
    fn write(&self, index: usize, mut frame: FinishedFrame) -> FrameResult {
        let files = &self.frames[index];
        if let Some(provenance) = &self.provenance {
            (frame.plate).set_provenance(provenance, files.number, &frame.record);
        }
        frame.write(&files.output)
    }

    /// Takes all frames through `work`, writes them, and prints their warnings and the files written.
    ///
    /// # Errors
    /// The error of a single plate, or those of all frames that failed.
    pub(crate) fn process(
        &self,
        work: &impl ViewWork,
        console: &mut Console,
    ) -> Result<(), CommandError> {
        let count = self.frames.len();
        let mut failed = Vec::new();
        let write = |index, frame| self.write(index, frame);
        run_pipeline(
            &AllViews(work),
            write,
            count,
            &self.resources,
            |index, result| {
                let frame = &self.frames[index];
                let report = || failed.extend(report_frame(frame, result, console));
                self.bar.suspend(report);
                self.show_progress(index, 1.0);
            },
        );
        self.bar.clear();
        match failed.len() {
            0 => Ok(()),
            1 if count == 1 => Err(failed.remove(0).1),
            _ => Err(CommandError::Frames { failed, count }),
        }
    }
}

/// Prints the warnings and outputs of a frame. Returns its number and error if it failed.
fn report_frame(
    frame: &FrameFiles,
    result: FrameResult,
    console: &mut Console,
) -> Option<(i64, CommandError)> {
    let prefix = frame
        .number
        .map_or_else(String::new, |number| format!("frame {number}: "));
    let warnings = match &result {
        Ok(warnings) => warnings,
        Err(failed) => &failed.warnings,
    };
    for warning in warnings {
        console.note(format!("{prefix}{warning}"));
    }
    let outputs: Vec<_> = frame.outputs().map(Path::to_string_lossy).collect();
    console.event(&match &result {
        Ok(_) => json!({"event": "frame", "frame": frame.number, "written": outputs}),
        Err(failed) => {
            let error = failed.error.to_string();
            json!({"event": "frame", "frame": frame.number, "error": error})
        }
    });
    match result {
        Ok(_) => {
            for path in frame.outputs() {
                console.print(format!("wrote {}", path.display()));
            }
            None
        }
        Err(failed) => {
            if frame.number.is_some() {
                console.note(format!(
                    "{prefix}failed; the error is printed at the end of the run"
                ));
            }
            Some((frame.number.unwrap_or(0), failed.error))
        }
    }
}
