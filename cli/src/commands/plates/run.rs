//! A run over one picture or the frames of a sequence: what of them exists already, how they are worked on, what is said.

use std::ffi::OsString;
use std::path::Path;

use clap::Args;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::frames::{Files, FrameFiles};
use super::memory::{DEFAULT_MEMORY, parse_size};
use super::queue::{Outcome, Pools, Stages, run_all};
use super::shares::Shares;
use crate::Console;
use crate::commands::CommandError;
use seidel_image_io::plate::Plate;
use seidel_image_io::provenance::Provenance;
use seidel_image_io::sequence::{FramePattern, expand_frames};

/// Options about which frames are rendered, and with what means.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Frames to render where IN and OUT hold a frame pattern, such as 1001-1100 or 1-9x2
    #[arg(long)]
    frames: Option<String>,
    /// Threads to work with; all cores if left out
    #[arg(long)]
    threads: Option<usize>,
    /// Memory for the frames of a sequence that are read, worked on and written at once, such as 500M
    /// or 4G; one frame is always in flight
    #[arg(long, value_name = "SIZE", default_value = DEFAULT_MEMORY, value_parser = parse_size)]
    memory: u64,
    /// Render frames of a sequence again whose output exists already; they are skipped otherwise
    #[arg(long)]
    overwrite: bool,
    /// Do not write into OUT what made it: version, command, lens and settings, which `seidel info` shows
    #[arg(long)]
    no_provenance: bool,
}

impl RunArgs {
    /// Whether frames are named.
    pub(crate) fn has_frames(&self) -> bool {
        self.frames.is_some()
    }

    /// The frames that there are to render; `lenses` are read as well. Says how many exist already.
    pub(crate) fn frames(
        &self,
        files: &Files,
        lenses: &[&Path],
        console: &mut Console,
    ) -> Result<Vec<FrameFiles>, CommandError> {
        let mut patterns = vec![files.input, files.output];
        patterns.extend(&files.read);
        patterns.extend(files.written.iter().map(|(_, pattern)| pattern));
        let all = expand_frames(&patterns, self.frames.as_deref())?;
        if all.len() > 1 {
            for (option, pattern) in &files.written {
                if !FramePattern::parse(pattern).has_frame() {
                    return Err(CommandError::Usage(format!(
                        "{option} needs a frame pattern as -o has one, such as name.%04d.exr"
                    )));
                }
            }
        }
        let all: Vec<FrameFiles> = all
            .into_iter()
            .map(|step| FrameFiles::new(step, files.read.len()))
            .collect();
        for frame in &all {
            frame.check(lenses)?;
        }
        let count = all.len();
        let todo: Vec<FrameFiles> = all.into_iter().filter(|f| !self.is_done(f)).collect();
        if todo.len() < count {
            console.remark(format!(
                "{} of {count} frames exist already and are skipped; give --overwrite to render them again",
                count - todo.len(),
            ));
        }
        Ok(todo)
    }

    /// Whether a frame of a sequence was rendered by an earlier run: outputs are whole or not there.
    fn is_done(&self, frame: &FrameFiles) -> bool {
        frame.number.is_some() && !self.overwrite && frame.outputs().all(Path::exists)
    }

    /// A run that does `what` to `frames`, whose outputs say of what made them the command line `words` and the `lenses` that it
    /// names, each with what it is there for.
    pub(crate) fn begin(
        &self,
        what: &str,
        frames: Vec<FrameFiles>,
        (words, lenses): (&[OsString], &[(&str, &Path)]),
        console: &Console,
    ) -> Result<Run, CommandError> {
        let mut provenance = (!self.no_provenance).then(|| Provenance::new(words));
        for (role, path) in lenses {
            provenance = provenance
                .map(|made| made.with_file(role, path))
                .transpose()?;
        }
        Ok(Run {
            pools: Pools {
                reading: self.pool()?,
                blurring: self.pool()?,
            },
            shares: Shares::new(console, what, frames.len()),
            memory: self.memory,
            provenance,
            frames,
        })
    }

    /// Threads for a stage of the run.
    fn pool(&self) -> Result<ThreadPool, CommandError> {
        ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0))
            .build()
            .map_err(|e| CommandError::Usage(format!("--threads: {e}")))
    }
}

/// A run: its frames, and what they are worked on with.
pub(crate) struct Run {
    frames: Vec<FrameFiles>,
    /// Where files are unpacked: not where frames are worked on, so that both go on at once.
    pools: Pools,
    shares: Shares,
    memory: u64,
    provenance: Option<Provenance>,
}

impl Run {
    /// The files of a frame.
    pub(crate) fn frame(&self, index: usize) -> &FrameFiles {
        &self.frames[index]
    }

    /// Tells that `part` of the work on the frame at `index` is done.
    pub(crate) fn tell(&self, index: usize, part: f64) {
        self.shares.tell(index, part);
    }

    /// Records in `plate`, the frame at `index`, the command and the `settings` that made it, unless provenance is off.
    pub(crate) fn set_provenance(
        &self,
        index: usize,
        plate: &mut Plate,
        settings: &[(String, String)],
    ) {
        if let Some(provenance) = &self.provenance {
            plate.set_provenance(provenance, self.frames[index].number, settings);
        }
    }

    /// Writes `plate` as the frame at `index`; what the user should know of it, after what was `said` already.
    pub(crate) fn write(&self, index: usize, plate: Plate, mut said: Vec<String>) -> Outcome {
        said.extend(plate.write(&self.frames[index].output)?);
        Ok(said)
    }

    /// Takes all frames through `stages` and says what became of them.
    pub(crate) fn through<S: Stages>(
        &self,
        stages: &S,
        console: &mut Console,
    ) -> Result<(), CommandError> {
        let count = self.frames.len();
        let mut failed = Vec::new();
        run_all(stages, &self.pools, count, self.memory, |index, outcome| {
            let speak = || tell(&self.frames[index], outcome, console, &mut failed);
            self.shares.hidden(speak);
        });
        self.shares.clear();
        match failed.len() {
            0 => Ok(()),
            1 if count == 1 => Err(failed.remove(0).1),
            _ => Err(CommandError::Frames { failed, count }),
        }
    }
}

/// Says what became of a frame, or keeps for the end why it failed.
fn tell(
    frame: &FrameFiles,
    outcome: Outcome,
    console: &mut Console,
    failed: &mut Vec<(i64, CommandError)>,
) {
    let prefix = frame
        .number
        .map_or_else(String::new, |number| format!("frame {number}: "));
    match outcome {
        Ok(said) => {
            for line in said {
                console.remark(format!("{prefix}{line}"));
            }
            for path in frame.outputs() {
                console.say(format!("wrote {}", path.display()));
            }
        }
        Err(error) => {
            if frame.number.is_some() {
                console.remark(format!("{prefix}failed; the end of this run says why"));
            }
            failed.push((frame.number.unwrap_or(0), error));
        }
    }
}
