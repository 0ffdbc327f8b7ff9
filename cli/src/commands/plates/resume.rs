//! Frames that an earlier run finished.

use std::path::Path;

use rayon::prelude::*;

use super::frames::FrameFiles;
use crate::Console;
use seidel_image_io::description::Description;
use seidel_image_io::error::FileError;
use seidel_image_io::provenance::{CommandChange, Provenance};

/// The outputs of a frame before a run.
enum FrameState {
    /// They are those of this run.
    Finished,
    /// One is missing.
    Missing,
    /// One is not of this run, for this reason.
    Other(String),
}

/// Returns the frames of `all` that are to be processed: those without finished outputs. Prints notes about the others.
///
/// Outputs are finished if they have the `provenance` of the run, in any format. A run without provenance keeps all images.
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
    for (state, frame) in states {
        match state {
            FrameState::Finished => continue,
            FrameState::Missing => {}
            FrameState::Other(reason) => others.push(reason),
        }
        frames.push(frame);
    }
    if frames.len() < count {
        let kept = count - frames.len();
        console.note(format!("{kept} of {count} frames are finished and kept"));
        if provenance.is_none() {
            console.note(
                "only their names were checked: with --provenance none, files hold no settings for --skip-existing to compare",
            );
        }
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
    for (index, path) in frame.outputs().enumerate() {
        let reason = match read_texts(path) {
            // Seidel writes whole files or none, but other programs may have written this one.
            Err(_) => Some("cannot be read as an image".to_owned()),
            // Maps beside OUT have no provenance.
            Ok(texts) if index == 0 => {
                provenance.and_then(|provenance| difference(&texts, frame.number, provenance))
            }
            Ok(_) => None,
        };
        if let Some(reason) = reason {
            return FrameState::Other(format!("{} {reason}", path.display()));
        }
    }
    FrameState::Finished
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
    let Some(change) = provenance.command_change(frame, texts) else {
        return Some("does not say what made it".to_owned());
    };
    let CommandChange::Options { before, now } = change else {
        return None;
    };
    let which = match (before.as_str(), now.as_str()) {
        ("", "") => ": in another order".to_owned(),
        ("", now) => format!(": now also {now}"),
        (before, "") => format!(": {before}"),
        (before, now) => format!(": {before}, now {now}"),
    };
    Some(format!("was made with other options{which}"))
}

/// Returns the provenance of an image file. That of OpenEXR files is read without their pixels.
fn read_texts(path: &Path) -> Result<Vec<(String, String)>, FileError> {
    let description = Description::read(path)?;
    let parts = description.parts.into_iter();
    Ok(parts.flat_map(|part| part.provenance).collect())
}
