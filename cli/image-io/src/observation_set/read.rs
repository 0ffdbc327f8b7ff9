//! Reading an observation set. All of its faults are reported together.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use seidel_optics::error::Fault;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::tile::Tile;
use serde_json::Value;

use super::faults::Faults;
use super::set_entry::{self, SetEntry};
use super::text::{is_inside, quote_non_finite};
use super::{MANIFEST, PLANE, observation_entry};
use crate::error::{FileError, Result};
use crate::json::{TEXT_LIMIT_BYTES, parse_json, read_text};
use crate::tile_image;

/// Options of reading a set.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Skip observations with faults instead of refusing the set.
    pub skip_bad: bool,
}

/// An observation set that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedSet {
    /// The observations without faults.
    pub set: ObservationSet,
    /// The observations that were skipped; empty without [`ReadOptions::skip_bad`].
    pub skipped: Vec<SkippedObservation>,
}

/// An observation that was skipped.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SkippedObservation {
    /// Its index in the manifest.
    pub index: usize,
    /// Its faults.
    pub faults: Vec<Fault>,
}

/// Reads the set in a folder, or that of a manifest file.
///
/// # Errors
/// All faults of all observations, by observation and field. Faults of the set itself are errors whatever the options
/// are, and so is a set without any valid observation.
pub fn read(path: &Path, options: ReadOptions) -> Result<LoadedSet> {
    let manifest = manifest_path(path)?;
    let text = read_text(&manifest, TEXT_LIMIT_BYTES)?;
    let root: Value = match parse_json(&manifest, &text) {
        Ok(root) => root,
        // JSON has no NaN, but a fault that names the observation and field is more useful than one that names the line.
        Err(error) => parse_json(&manifest, &quote_non_finite(&text)).map_err(|_| error)?,
    };
    let folder = manifest.parent().unwrap_or(Path::new("")).to_path_buf();
    let mut set_faults = Faults::default();
    let Some(mut set) = set_entry::read(root, &mut set_faults) else {
        return Err(FileError::many(manifest, set_faults.all));
    };
    let mut set_faults = set_faults.all;
    let entries = std::mem::take(&mut set.observations);

    let read: Vec<std::result::Result<Observation, Vec<Fault>>> = entries
        .into_par_iter()
        .enumerate()
        .map(|(index, value)| read_observation(&folder, value, index, &set))
        .collect();
    let mut faults: Vec<Vec<Fault>> = vec![Vec::new(); read.len()];
    let mut indices = Vec::new();
    let mut observations = Vec::new();
    for (index, result) in read.into_iter().enumerate() {
        match result {
            Ok(observation) => {
                indices.push(index);
                observations.push(observation);
            }
            Err(found) => faults[index] = found,
        }
    }
    let mut loaded = ObservationSet {
        frame: set.frame,
        axis_stated: set.axis_stated,
        pixel_pitch_um: set.pixel_pitch_um,
        channels: set.channels,
        camera: set.camera,
        mosaic: set.mosaic,
        observations,
    };
    for mut fault in loaded.faults() {
        match fault.observation {
            Some(place) => {
                fault.observation = Some(indices[place]);
                faults[indices[place]].push(fault);
            }
            // If all observations are bad, the emptiness of the set is not a fault of its own.
            None if fault.field == "observations" && !faults.is_empty() => {}
            None => set_faults.push(fault),
        }
    }
    let bad = faults.iter().filter(|f| !f.is_empty()).count();
    let none_left = bad == faults.len();
    if !set_faults.is_empty() || (bad > 0 && (!options.skip_bad || none_left)) {
        set_faults.extend(faults.into_iter().flatten());
        return Err(FileError::many(manifest, set_faults));
    }
    let keep: Vec<bool> = indices.iter().map(|&i| faults[i].is_empty()).collect();
    let mut keep = keep.into_iter();
    // The iterator has one entry per observation, in order.
    loaded.observations.retain(|_| keep.next().unwrap_or(false));
    let skipped = faults
        .into_iter()
        .enumerate()
        .filter(|(_, faults)| !faults.is_empty())
        .map(|(index, faults)| SkippedObservation { index, faults })
        .collect();
    Ok(LoadedSet {
        set: loaded,
        skipped,
    })
}

fn manifest_path(path: &Path) -> Result<PathBuf> {
    if !path.is_dir() {
        return Ok(path.to_path_buf());
    }
    let manifest = path.join(MANIFEST);
    if manifest.is_file() {
        return Ok(manifest);
    }
    Err(FileError::new(
        path,
        "",
        format!("contains no {MANIFEST}"),
        "give the folder of an observation set, or its manifest",
    ))
}

fn read_observation(
    folder: &Path,
    value: Value,
    index: usize,
    set: &SetEntry,
) -> std::result::Result<Observation, Vec<Fault>> {
    let channels = &set.channels;
    let text = |key| value.get(key).and_then(Value::as_str).map(str::to_owned);
    let (file, mask) = (text("file").unwrap_or_default(), text("weight_mask"));
    let mut faults = Faults::of_observation(index, &file);
    let observation = observation_entry::read(value, channels, &mut faults);
    // The images are read even if another field is bad, so that their faults are reported too.
    let mut tiles = Vec::new();
    if is_inside(&file) {
        // All channels of a mosaic share its only plane.
        let plane = [PLANE.to_owned()];
        let stored = match set.mosaic {
            Some(_) => &plane[..],
            None => &channels[..],
        };
        match tile_image::read(&folder.join(&file), stored) {
            Ok(planes) => {
                for (channel, plane) in stored.iter().zip(planes) {
                    match Tile::new(plane.width, plane.height, plane.samples) {
                        Ok(tile) => tiles.push(tile),
                        Err(error) => {
                            faults.push(format!("channel {channel}"), error.problem, error.remedy)
                        }
                    }
                }
            }
            Err(error) => faults.all.extend(error.into_faults(index, &file)),
        }
    }
    if let (Some(_), [tile]) = (set.mosaic, tiles.as_slice()) {
        tiles = vec![tile.clone(); channels.len()];
    }
    let weight_mask = mask.filter(|mask| is_inside(mask)).and_then(|mask| {
        match tile_image::read(&folder.join(&mask), &[PLANE.to_owned()]) {
            Ok(planes) => Some(planes[0].samples.iter().map(|v| *v > 0.0).collect()),
            Err(error) => {
                faults.all.extend(error.into_faults(index, &mask));
                None
            }
        }
    });
    match observation {
        Some(observation) if faults.all.is_empty() => Ok(Observation {
            tiles,
            weight_mask,
            ..observation
        }),
        _ => Err(faults.all),
    }
}
