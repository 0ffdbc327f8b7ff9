//! Writing an observation set as a folder.

use std::collections::HashSet;
use std::path::Path;

use rayon::prelude::*;
use seidel_optics::camera::Camera;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::observations::{ChannelMeasurement, Observation, ObservationSet};
use seidel_optics::tile::Tile;
use serde_json::{Value, json};

use super::text::is_inside;
use super::{FORMAT, MANIFEST, MOSAIC_VERSION, PLANE, VERSION};
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
    let axis = set.frame.axis();
    let version = set.mosaic.map_or(VERSION, |_| MOSAIC_VERSION);
    let camera = camera(&set.camera);
    let entries = set.observations.iter().zip(names.iter().zip(masks));
    let entries = entries.map(|(o, (name, mask))| observation(o, name, mask, &set.channels));
    stated(json!({
        "format": FORMAT,
        "version": version,
        "image_size": [set.frame.width_px(), set.frame.height_px()],
        "optical_axis": set.axis_stated.then_some([axis.x_px, axis.y_px]),
        "pixel_pitch_um": set.pixel_pitch_um,
        "channels": set.channels,
        "mosaic": set.mosaic.map(|mosaic| mosaic.to_string()),
        "camera": (camera != json!({})).then_some(camera),
        "observations": entries.collect::<Vec<_>>(),
    }))
}

fn camera(camera: &Camera) -> Value {
    let wavelengths = &camera.wavelength_nm;
    let entry = stated(json!({
        "focal_length_mm": camera.focal_length_mm,
        "f_number": camera.f_number,
        "wavelength_nm": (!wavelengths.is_empty()).then_some(wavelengths),
        "squeeze": camera.squeeze,
        "lens_model": camera.lens_model,
        "lens_serial_number": camera.lens_serial_number,
    }));
    with_distance(entry, "focus_distance_m", camera.focus_distance)
}

fn observation(o: &Observation, name: &str, mask: &Option<String>, channels: &[String]) -> Value {
    let background: Vec<Option<f64>> = o.background.iter().copied().map(Some).collect();
    let has_background = o.background.iter().any(|&b| b != 0.0);
    let has_noise = o.noise_sigma.iter().any(Option::is_some);
    let measurement = o.measurement.as_ref();
    let figures = |value: fn(&ChannelMeasurement) -> Value| {
        let pairs = channels.iter().zip(&measurement?.channels);
        let pairs = pairs.filter_map(|(name, m)| Some((name.clone(), value(m.as_ref()?))));
        Some(pairs.collect::<Value>())
    };
    let entry = stated(json!({
        "file": name,
        "x": o.centre.x_px,
        "y": o.centre.y_px,
        "ideal_x": o.ideal.map(|ideal| ideal.x_px),
        "ideal_y": o.ideal.map(|ideal| ideal.y_px),
        "noise_sigma": has_noise.then(|| by_channel(&o.noise_sigma, channels)),
        "background": has_background.then(|| by_channel(&background, channels)),
        "saturated": o.saturated.then_some(true),
        "gain": o.gain,
        "weight_mask": mask,
        "source": measurement.map(|m| &m.source),
        "centroid": figures(|m| json!([m.centroid.x_px, m.centroid.y_px])),
        "centroid_sigma": figures(|m| json!(m.centroid_sigma_px)),
        "flux": figures(|m| json!(m.flux)),
        "snr": figures(|m| json!(m.snr)),
    }));
    with_distance(entry, "depth_m", o.distance)
}

/// Returns an object without the keys that have no value.
fn stated(mut object: Value) -> Value {
    if let Some(keys) = object.as_object_mut() {
        keys.retain(|_, value| !value.is_null());
    }
    object
}

/// Adds a distance to an object: null is infinity, and no key an unknown one.
fn with_distance(mut object: Value, key: &str, distance: ObjectDistance) -> Value {
    match distance {
        ObjectDistance::Unknown => {}
        ObjectDistance::Infinity => object[key] = Value::Null,
        ObjectDistance::Metres(metres) => object[key] = json!(metres),
    }
    object
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
