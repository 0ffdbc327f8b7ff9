//! Frames that an earlier run finished.

use std::path::Path;

use rayon::prelude::*;

use super::frames::FrameFiles;
use crate::Console;
use seidel_image_io::description::Description;
use seidel_image_io::error::FileError;
use seidel_image_io::format::Format;
use seidel_image_io::provenance::Provenance;

/// The outputs of a frame before a run.
enum FrameState {
    /// They are those of this run.
    Finished,
    /// They exist, in a format that does not say what made them.
    Unknown,
    /// One is missing.
    Missing,
    /// One is not of this run, for this reason.
    Other(String),
}

/// Returns the frames of `all` that are to be processed: those without finished outputs. Prints notes about the others.
///
/// Outputs are finished if they have the `provenance` of the run. A run without provenance keeps all images.
pub(super) fn unfinished(
    all: Vec<FrameFiles>,
    provenance: Option<&Provenance>,
    console: &mut Console,
) -> Vec<FrameFiles> {
    let count = all.len();
    // In parallel, because each header takes a round trip where files lie on another machine.
    let states = all
        .into_par_iter()
        .map(|frame| (state(&frame, provenance), frame));
    let states: Vec<(FrameState, FrameFiles)> = states.collect();
    let (mut frames, mut others) = (Vec::new(), Vec::new());
    let mut unknown = 0;
    for (state, frame) in states {
        match state {
            FrameState::Finished => continue,
            FrameState::Unknown => {
                unknown += 1;
                continue;
            }
            FrameState::Missing => {}
            FrameState::Other(reason) => others.push(reason),
        }
        frames.push(frame);
    }
    if frames.len() < count {
        let kept = count - frames.len();
        console.note(format!("{kept} of {count} frames are finished and kept"));
    }
    if unknown > 0 {
        console.note(format!(
            "{unknown} of them do not say what made them; leave out --skip-existing to render them again"
        ));
    }
    if let Some(first) = others.first() {
        console.note(format!(
            "{} of {count} frames exist but are not of this run and are rendered again; the first: {first}",
            others.len(),
        ));
    }
    frames
}

fn state(frame: &FrameFiles, provenance: Option<&Provenance>) -> FrameState {
    if !frame.outputs().all(Path::exists) {
        return FrameState::Missing;
    }
    let mut state = FrameState::Unknown;
    for (index, path) in frame.outputs().enumerate() {
        let reason = match (read_texts(path), provenance) {
            // Outputs are whole if they exist, because files are written whole or not at all: but other programs write
            // too.
            (Err(_), _) => Some("is no image that can be read".to_owned()),
            (Ok(Some(texts)), Some(provenance)) => match index {
                0 => {
                    state = FrameState::Finished;
                    difference(&texts, frame.number, provenance)
                }
                // Maps beside OUT say nothing.
                _ => None,
            },
            _ => None,
        };
        if let Some(reason) = reason {
            return FrameState::Other(format!("{} {reason}", path.display()));
        }
    }
    state
}

/// Returns how a file with these `texts` differs from what a run makes of `frame`.
fn difference(
    texts: &[(String, String)],
    frame: Option<i64>,
    provenance: &Provenance,
) -> Option<String> {
    if let Some(file) = provenance.differing_file(texts) {
        let reason = format!(
            "was made with {}, but this run uses {}",
            file.before, file.now
        );
        return Some(reason);
    }
    match provenance.is_other_command(frame, texts) {
        None => Some("does not say what made it".to_owned()),
        Some(true) => Some("was made with other options".to_owned()),
        Some(false) => None,
    }
}

/// Returns the provenance of an image file. Only that of OpenEXR files can be read without their pixels; others are only
/// recognised.
fn read_texts(path: &Path) -> Result<Option<Vec<(String, String)>>, FileError> {
    if Format::from_path(path) != Some(Format::Exr) {
        return seidel_image_io::format::detect(path).map(|_| None);
    }
    let description = Description::read(path)?;
    let parts = description.parts.into_iter();
    Ok(Some(parts.flat_map(|part| part.provenance).collect()))
}
