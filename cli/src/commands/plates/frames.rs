//! The files of a run, and those of each of its frames.

use std::path::{Path, PathBuf};

use super::SideInputs;
use crate::commands::CommandError;
use seidel_image_io::atomic::check_target;
use seidel_image_io::error::FileError;
use seidel_image_io::formats::output_format;
use seidel_image_io::sequence::FramePattern;

/// The files of a run: paths or frame patterns.
pub(crate) struct Files<'a> {
    /// Plate to read.
    pub(crate) input: &'a Path,
    /// Plate to write.
    pub(crate) output: &'a Path,
    pub(crate) read: SideInputs,
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
    pub(crate) read: SideInputs,
    /// Other images to write, each with its option.
    pub(crate) written: Vec<(&'static str, PathBuf)>,
}

impl Files<'_> {
    /// Returns the files of frame `number`; without one, those of a single picture.
    pub(super) fn at_frame(&self, number: Option<i64>) -> FrameFiles {
        let path = |pattern: &Path| match number {
            Some(number) => FramePattern::parse(pattern).path(number),
            None => pattern.to_owned(),
        };
        let written = (self.written.iter()).map(|(option, file)| (*option, path(file)));
        FrameFiles {
            number,
            input: path(self.input),
            output: path(self.output),
            read: self.read.with_paths(path),
            written: written.collect(),
        }
    }
}

impl FrameFiles {
    /// Returns the paths of all outputs.
    pub(super) fn outputs(&self) -> impl Iterator<Item = &Path> {
        let written = self.written.iter().map(|(_, path)| path);
        [&self.output]
            .into_iter()
            .chain(written)
            .map(PathBuf::as_path)
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
            let mut inputs = self.read.paths();
            inputs.push(self.input.clone());
            inputs.extend(lenses.iter().map(|(_, path)| path.to_path_buf()));
            if inputs
                .iter()
                .any(|path| path.canonicalize().is_ok_and(|path| path == target))
            {
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
