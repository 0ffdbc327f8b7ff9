//! The files of a run, and those of each of its frames.

use std::path::{Path, PathBuf};

use crate::commands::CommandError;
use seidel_image_io::atomic::check_target;
use seidel_image_io::error::FileError;
use seidel_image_io::formats::output_format;
use seidel_image_io::sequence::FramePaths;

/// The files of a run: paths or frame patterns.
pub(crate) struct Files<'a> {
    /// Plate to read.
    pub(crate) input: &'a Path,
    /// Plate to write.
    pub(crate) output: &'a Path,
    /// Other images to read; each may be one file for all frames.
    pub(crate) read: Vec<&'a Path>,
    /// Other images to write, each with its option.
    pub(crate) written: Vec<(&'static str, &'a Path)>,
    /// Lens profiles, each with its role in the provenance.
    pub(crate) lenses: Vec<(&'static str, &'a Path)>,
}

/// The files of a frame.
#[derive(Debug)]
pub(crate) struct FrameFiles {
    /// Number of the frame; `None` for a single picture.
    pub(crate) number: Option<i64>,
    pub(crate) input: PathBuf,
    pub(crate) output: PathBuf,
    /// In the order of [`Files::read`].
    pub(crate) read: Vec<PathBuf>,
    /// In the order of [`Files::written`].
    pub(crate) written: Vec<PathBuf>,
}

impl FrameFiles {
    /// Sorts the paths of a frame: the input, the output, `read_count` other inputs, other outputs.
    pub(super) fn new(frame: FramePaths, read_count: usize) -> Self {
        let mut paths = frame.paths.into_iter();
        let (input, output) = (paths.next(), paths.next());
        Self {
            number: frame.frame,
            input: input.unwrap_or_default(),
            output: output.unwrap_or_default(),
            read: paths.by_ref().take(read_count).collect(),
            written: paths.collect(),
        }
    }

    /// Returns the paths of all outputs.
    pub(super) fn outputs(&self) -> impl Iterator<Item = &Path> {
        let outputs = [&self.output].into_iter().chain(&self.written);
        outputs.map(PathBuf::as_path)
    }

    /// Rejects an output of no writable format, and one that would replace another output, an input or a lens.
    pub(super) fn check(&self, lenses: &[(&str, &Path)]) -> Result<(), CommandError> {
        output_format(&self.output)?;
        for (index, output) in self.outputs().enumerate() {
            check_target(output)?;
            if self.outputs().take(index).any(|other| other == output) {
                return Err(FileError::new(
                    output,
                    "",
                    "is the name of two outputs",
                    "give each output a name of its own",
                )
                .into());
            }
            // An output that does not exist yet replaces nothing.
            let Ok(target) = output.canonicalize() else {
                continue;
            };
            let inputs = [&self.input].into_iter().chain(&self.read);
            let mut inputs = inputs
                .map(PathBuf::as_path)
                .chain(lenses.iter().map(|(_, path)| *path));
            if inputs.any(|path| path.canonicalize().is_ok_and(|path| path == target)) {
                return Err(FileError::new(
                    output,
                    "",
                    "is read by this command and would be overwritten",
                    "give the output another name",
                )
                .into());
            }
        }
        Ok(())
    }
}
