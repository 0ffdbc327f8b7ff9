//! The files of a run, and those of each of its frames.

use std::path::{Path, PathBuf};

use crate::commands::CommandError;
use seidel_image_io::atomic::check_target;
use seidel_image_io::error::FileError;
use seidel_image_io::format::output_format;
use seidel_image_io::sequence::FramePaths;

/// The files of a run: paths or frame patterns.
pub(crate) struct Files<'a> {
    /// The plate.
    pub(crate) input: &'a str,
    /// What is made of it.
    pub(crate) output: &'a str,
    /// What else is read, which may be one file for all frames.
    pub(crate) read: Vec<&'a str>,
    /// What else is written, each with its option.
    pub(crate) written: Vec<(&'static str, &'a str)>,
}

/// The files of a frame.
#[derive(Debug)]
pub(crate) struct FrameFiles {
    /// Its number; `None` for a single picture.
    pub(crate) number: Option<i64>,
    pub(crate) input: PathBuf,
    pub(crate) output: PathBuf,
    /// As in [`Files::read`].
    pub(crate) read: Vec<PathBuf>,
    /// As in [`Files::written`].
    pub(crate) written: Vec<PathBuf>,
}

impl FrameFiles {
    pub(super) fn new(frame: FramePaths, read: usize) -> Self {
        let mut paths = frame.paths.into_iter();
        let (input, output) = (paths.next(), paths.next());
        Self {
            number: frame.frame,
            input: input.unwrap_or_default(),
            output: output.unwrap_or_default(),
            read: paths.by_ref().take(read).collect(),
            written: paths.collect(),
        }
    }

    pub(super) fn outputs(&self) -> impl Iterator<Item = &Path> {
        [&self.output]
            .into_iter()
            .chain(&self.written)
            .map(PathBuf::as_path)
    }

    /// Refuses an output of no format that is written, and one that would take the place of another or of a file the run reads.
    pub(super) fn check(&self, lenses: &[&Path]) -> Result<(), CommandError> {
        output_format(&self.output)?;
        for (index, output) in self.outputs().enumerate() {
            check_target(output)?;
            if self.outputs().take(index).any(|other| other == output) {
                return Err(FileError::new(
                    output,
                    "",
                    "is named for two outputs",
                    "give each a name of its own",
                )
                .into());
            }
            // An output that does not exist yet replaces nothing.
            let Ok(target) = output.canonicalize() else {
                continue;
            };
            let inputs = [&self.input].into_iter().chain(&self.read);
            let lost = inputs
                .map(PathBuf::as_path)
                .chain(lenses.iter().copied())
                .any(|path| path.canonicalize().is_ok_and(|p| p == target));
            if lost {
                return Err(FileError::new(
                    output,
                    "",
                    "is read by this command and would be overwritten",
                    "give another name to -o",
                )
                .into());
            }
        }
        Ok(())
    }
}
