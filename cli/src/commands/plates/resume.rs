//! Frames of a sequence that an earlier run finished.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::frames::FrameFiles;
use crate::Console;
use crate::commands::CommandError;
use seidel_image_io::description::Description;
use seidel_image_io::error::FileError;
use seidel_image_io::format::Format;
use seidel_image_io::provenance::Provenance;

/// Remedy for an output that another run made.
const REMEDY: &str = "give --overwrite to render the frame again, or name another OUT";

/// An existing frame of a run.
enum FrameState {
    /// Its outputs are those of this run.
    Finished,
    /// Its outputs were made by another command line, of the same lens.
    OtherOptions,
    /// An output is missing.
    Missing,
    /// An output has no content.
    Empty(PathBuf),
    /// An output was made with another lens, or is no image that can be read.
    Foreign(FileError),
}

/// Returns the frames that are to be processed: those of `all` without finished outputs. Prints notes about the others.
///
/// # Errors
/// An output that was made with another lens than that of `provenance`, or is no image.
pub(super) fn unfinished(
    all: Vec<FrameFiles>,
    provenance: &Provenance,
    console: &mut Console,
) -> Result<Vec<FrameFiles>, CommandError> {
    let count = all.len();
    // In parallel, because each header takes a round trip where files lie on another machine.
    let states = all
        .into_par_iter()
        .map(|frame| (state(&frame, provenance), frame));
    let states: Vec<(FrameState, FrameFiles)> = states.collect();
    let mut frames = Vec::new();
    let mut other_options = Vec::new();
    for (state, frame) in states {
        match state {
            FrameState::Finished => {}
            FrameState::OtherOptions => other_options.extend(frame.number),
            FrameState::Missing => frames.push(frame),
            FrameState::Empty(path) => {
                let path = path.display();
                console.note(format!("{path}: is empty; the frame is rendered again"));
                frames.push(frame);
            }
            FrameState::Foreign(error) => return Err(error.into()),
        }
    }
    if frames.len() < count {
        console.note(format!(
            "{} of {count} frames exist already and are skipped; give --overwrite to render them again",
            count - frames.len(),
        ));
    }
    if let Some(first) = other_options.first() {
        console.note(format!(
            "{} of them were made with other options, first frame {first}; `seidel info` shows these",
            other_options.len()
        ));
    }
    Ok(frames)
}

fn state(frame: &FrameFiles, provenance: &Provenance) -> FrameState {
    // Outputs are complete if they exist, because files are written whole or not at all: but other programs write too.
    if !frame.outputs().all(Path::exists) {
        return FrameState::Missing;
    }
    let is_empty = |path: &Path| path.metadata().is_ok_and(|file| file.len() == 0);
    if let Some(path) = frame.outputs().find(|path| is_empty(path)) {
        return FrameState::Empty(path.to_path_buf());
    }
    let mut state = FrameState::Finished;
    for path in frame.outputs() {
        let texts = match read_texts(path) {
            Ok(texts) => texts,
            Err(error) => {
                let problem = format!("exists but is no frame of an earlier run ({error})");
                return FrameState::Foreign(FileError::new(path, "", problem, REMEDY));
            }
        };
        if let Some(file) = provenance.differing_file(&texts) {
            let problem = format!("is {}, but this run's is {}", file.before, file.now);
            return FrameState::Foreign(FileError::new(path, file.name, problem, REMEDY));
        }
        if provenance.is_other_command(frame.number, &texts) {
            state = FrameState::OtherOptions;
        }
    }
    state
}

/// Returns the provenance of an image file. Only that of OpenEXR files can be read without their pixels; others are
/// only recognised.
fn read_texts(path: &Path) -> Result<Vec<(String, String)>, FileError> {
    if Format::from_path(path) != Some(Format::Exr) {
        return seidel_image_io::format::detect(path).map(|_| Vec::new());
    }
    let description = Description::read(path)?;
    let parts = description.parts.into_iter();
    Ok(parts.flat_map(|part| part.provenance).collect())
}
