//! Writing an observation set as a folder.

use std::collections::HashSet;
use std::path::Path;

use rayon::prelude::*;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::tile::Tile;
use serde_json::{Map, Value, json};

use super::fields::is_inside;
use super::{FORMAT, MANIFEST, MOSAIC_VERSION, PLANE, VERSION, measurement};
use crate::atomic::write_folder_atomically;
use crate::error::{FileError, Result};
use crate::formats::exr;
use crate::formats::tiff;
use crate::json::write_json;
use crate::tile_image;

/// Writes a set as a folder, whole or not at all: the manifest, and float tiles under their names in the set.
///
/// A tile gets another name, ending in `.exr`, if its own has not the extension of EXR or TIFF or is taken.
///
/// # Errors
/// A folder that cannot be written or has other files, and values that the format does not allow.
pub fn write(set: &ObservationSet, folder: &Path) -> Result<()> {
    write_folder_atomically(folder, |temporary| write_into(set, temporary))
}

/// Writes a set into an existing folder, such as the one that [`write_folder_atomically`] passes to its closure.
///
/// # Errors
/// Those of [`write()`].
pub fn write_into(set: &ObservationSet, folder: &Path) -> Result<()> {
    let names = tile_names(set);
    let masks = mask_names(set);
    for name in names.iter().chain(masks.iter().flatten()) {
        let tile = folder.join(name);
        if let Some(parent) = tile.parent() {
            std::fs::create_dir_all(parent).map_err(|e| FileError::io(parent, "be created", &e))?;
        }
    }
    let plane = [PLANE.to_owned()];
    set.observations
        .par_iter()
        .zip(names.par_iter().zip(&masks))
        .try_for_each(|(observation, (name, mask_name))| {
            let path = folder.join(name);
            match set.mosaic {
                None => tile_image::write(&path, &set.channels, &observation.tiles)?,
                Some(_) => tile_image::write(&path, &plane, &observation.tiles[..1])?,
            }
            if let (Some(name), Some(mask)) = (mask_name, &observation.weight_mask) {
                let path = folder.join(name);
                let samples = mask.iter().map(|used| f32::from(u8::from(*used)));
                let tile = &observation.tiles[0];
                let mask = Tile::new(tile.width(), tile.height(), samples.collect())
                    .map_err(|error| FileError::from_core(&path, error))?;
                tile_image::write(&path, &plane, &[mask])?;
            }
            Ok(())
        })?;
    write_json(&folder.join(MANIFEST), &manifest(set, &names, &masks))
}

/// Returns a file name for every observation: its own if that is valid and free.
fn tile_names(set: &ObservationSet) -> Vec<String> {
    let fits_tiff = set.mosaic.is_some() || fits_tiff(&set.channels);
    let mut taken = HashSet::new();
    // New names are chosen last, so that they take none of these.
    let own: Vec<Option<String>> = set
        .observations
        .iter()
        .map(|o| {
            let path = Path::new(&o.file);
            let is_tiff = fits_tiff && tiff::FORMAT.is_name(path);
            let name = if is_tiff || exr::FORMAT.is_name(path) {
                o.file.clone()
            } else {
                path.with_extension("exr").to_string_lossy().into_owned()
            };
            // Some file systems ignore case.
            let is_free = is_inside(&name) && taken.insert(name.to_lowercase());
            is_free.then_some(name)
        })
        .collect();
    let mut number = 0;
    own.into_iter()
        .map(|name| {
            name.unwrap_or_else(|| {
                loop {
                    let name = format!("psf/{number:04}.exr");
                    number += 1;
                    if taken.insert(name.clone()) {
                        return name;
                    }
                }
            })
        })
        .collect()
}

/// Returns the file name of every observation's weight mask.
fn mask_names(set: &ObservationSet) -> Vec<Option<String>> {
    let name = |(index, observation): (usize, &Observation)| {
        let mask = observation.weight_mask.as_ref();
        mask.map(|_| format!("mask/{index:04}.tif"))
    };
    set.observations.iter().enumerate().map(name).collect()
}

/// Returns whether TIFF can store the channels, which have no names there.
fn fits_tiff(channels: &[String]) -> bool {
    channels.len() == 1 || channels == ["R", "G", "B"]
}

fn manifest(set: &ObservationSet, names: &[String], masks: &[Option<String>]) -> Value {
    let mut root = Map::new();
    let mut put = |key: &str, value: Value| root.insert(key.to_owned(), value);
    put("format", json!(FORMAT));
    let version = match set.mosaic {
        Some(_) => MOSAIC_VERSION,
        None => VERSION,
    };
    put("version", json!(version));
    put(
        "image_size",
        json!([set.frame.width_px(), set.frame.height_px()]),
    );
    if set.axis_stated {
        let axis = set.frame.axis();
        put("optical_axis", json!([axis.x_px, axis.y_px]));
    }
    if let Some(pitch) = set.pixel_pitch_um {
        put("pixel_pitch_um", json!(pitch));
    }
    put("channels", json!(set.channels));
    if let Some(mosaic) = &set.mosaic {
        put("mosaic", json!(mosaic.to_string()));
    }
    let camera = camera(set);
    if !camera.is_empty() {
        put("camera", Value::Object(camera));
    }
    let observations: Vec<Value> = set
        .observations
        .iter()
        .zip(names.iter().zip(masks))
        .map(|(o, (name, mask))| {
            let mut entry = observation(o, name, &set.channels);
            if let Some(mask) = mask {
                entry.insert("weight_mask".into(), json!(mask));
            }
            Value::Object(entry)
        })
        .collect();
    put("observations", Value::Array(observations));
    Value::Object(root)
}

fn camera(set: &ObservationSet) -> Map<String, Value> {
    let mut map = Map::new();
    if let Some(focal) = set.camera.focal_length_mm {
        map.insert("focal_length_mm".into(), json!(focal));
    }
    if let Some(f_number) = set.camera.f_number {
        map.insert("f_number".into(), json!(f_number));
    }
    put_distance(&mut map, "focus_distance_m", set.camera.focus_distance);
    if !set.camera.wavelength_nm.is_empty() {
        map.insert("wavelength_nm".into(), json!(set.camera.wavelength_nm));
    }
    if let Some(squeeze) = set.camera.squeeze {
        map.insert("squeeze".into(), json!(squeeze));
    }
    map
}

fn observation(o: &Observation, name: &str, channels: &[String]) -> Map<String, Value> {
    let mut map = Map::new();
    map.insert("file".into(), json!(name));
    map.insert("x".into(), json!(o.centre.x_px));
    map.insert("y".into(), json!(o.centre.y_px));
    put_distance(&mut map, "depth_m", o.distance);
    if let Some(ideal) = o.ideal {
        map.insert("ideal_x".into(), json!(ideal.x_px));
        map.insert("ideal_y".into(), json!(ideal.y_px));
    }
    if o.noise_sigma.iter().any(Option::is_some) {
        map.insert("noise_sigma".into(), by_channel(&o.noise_sigma, channels));
    }
    if o.background.iter().any(|&b| b != 0.0) {
        let all: Vec<Option<f64>> = o.background.iter().copied().map(Some).collect();
        map.insert("background".into(), by_channel(&all, channels));
    }
    if o.saturated {
        map.insert("saturated".into(), json!(true));
    }
    if let Some(gain) = o.gain {
        map.insert("gain".into(), json!(gain));
    }
    measurement::write(&mut map, o, channels);
    map
}

fn put_distance(map: &mut Map<String, Value>, key: &str, distance: ObjectDistance) {
    match distance {
        ObjectDistance::Unknown => {}
        ObjectDistance::Infinity => {
            map.insert(key.to_owned(), Value::Null);
        }
        ObjectDistance::Metres(metres) => {
            map.insert(key.to_owned(), json!(metres));
        }
    }
}

/// Returns one number if all channels agree, else an object of the channels that have one.
fn by_channel(values: &[Option<f64>], channels: &[String]) -> Value {
    match values {
        [Some(first), rest @ ..] if rest.iter().all(|v| *v == Some(*first)) => json!(first),
        _ => channels
            .iter()
            .zip(values)
            .filter_map(|(name, value)| Some((name.clone(), json!((*value)?))))
            .collect(),
    }
}
