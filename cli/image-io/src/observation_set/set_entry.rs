//! The keys of a manifest that describe the set as a whole.

use std::collections::BTreeMap;

use seidel_optics::camera::Camera;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::mosaic::Mosaic;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::faults::Faults;
use super::{FORMAT, MOSAIC_VERSION, VERSION};
use crate::json::present;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a JSON object")]
struct Keys {
    #[serde(rename = "format")]
    _format: String,
    version: u64,
    image_size: [f64; 2],
    optical_axis: Option<[f64; 2]>,
    pixel_pitch_um: Option<f64>,
    channels: Vec<String>,
    #[serde(default)]
    camera: Map<String, Value>,
    mosaic: Option<String>,
    observations: Vec<Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraKeys {
    focal_length_mm: Option<f64>,
    f_number: Option<f64>,
    #[serde(default, deserialize_with = "present")]
    focus_distance_m: Option<Option<f64>>,
    #[serde(default)]
    wavelength_nm: BTreeMap<String, f64>,
    squeeze: Option<f64>,
    lens_model: Option<String>,
    lens_serial_number: Option<String>,
}

/// The entry of the set as a whole.
pub(super) struct SetEntry {
    pub(super) frame: Frame,
    pub(super) axis_stated: bool,
    pub(super) pixel_pitch_um: Option<f64>,
    pub(super) channels: Vec<String>,
    pub(super) camera: Camera,
    pub(super) mosaic: Option<Mosaic>,
    pub(super) observations: Vec<Value>,
}

/// Reads the keys of the set; `None` if a fault prevents reading the observations.
pub(super) fn read(root: Value, faults: &mut Faults) -> Option<SetEntry> {
    // A file of another format or version has other keys, so only this fault is reported.
    let expected = [
        ("format", vec![json!(FORMAT)]),
        ("version", vec![json!(VERSION), json!(MOSAIC_VERSION)]),
    ];
    for (key, values) in expected.iter().filter(|_| root.is_object()) {
        let value = root.get(key);
        if !value.is_some_and(|value| values.contains(value)) {
            let problem = value.map_or("is missing".to_owned(), |value| format!("is {value}"));
            let problem: String = problem.chars().take(60).collect();
            let remedy = format!(
                "give a set of the format \"{FORMAT}\", of version {VERSION} or {MOSAIC_VERSION}"
            );
            faults.push(*key, problem, remedy);
            return None;
        }
    }
    let keys: Keys = faults.parse("", root)?;
    let mosaic = mosaic(&keys, faults);
    let axis = keys.optical_axis.map(|[x, y]| ImagePoint::new(x, y));
    let frame = frame(keys.image_size, axis, faults);
    if keys.channels.iter().any(String::is_empty) {
        let remedy = "give every channel a name, such as \"R\" or \"Y\"";
        faults.push("channels", "has a name without letters", remedy);
    }
    let pixel_pitch_um = faults.positive(
        "pixel_pitch_um",
        keys.pixel_pitch_um,
        "the pixel pitch in micrometres",
    );
    let camera = camera(keys.camera, faults);
    Some(SetEntry {
        frame: frame?,
        axis_stated: axis.is_some(),
        pixel_pitch_um,
        channels: keys.channels,
        camera: camera.unwrap_or_default(),
        mosaic,
        observations: keys.observations,
    })
}

/// Reads the mosaic, which sets of [`MOSAIC_VERSION`] have and no others.
fn mosaic(keys: &Keys, faults: &mut Faults) -> Option<Mosaic> {
    let is_needed = keys.version == MOSAIC_VERSION;
    let Some(name) = &keys.mosaic else {
        if is_needed {
            faults.push("mosaic", "is missing", MOSAIC_REMEDY);
        }
        return None;
    };
    if !is_needed {
        let problem = format!("is not a key of version {VERSION}");
        let remedy = format!("write the set as version {MOSAIC_VERSION}, or leave the key out");
        faults.push("mosaic", problem, remedy);
    }
    let mosaic = Mosaic::parse(name);
    mosaic
        .map_err(|_| faults.push("mosaic", format!("is {name:?}"), MOSAIC_REMEDY))
        .ok()
}

const MOSAIC_REMEDY: &str =
    "give the colours of the frame's top-left 2 x 2 pixels, such as \"RGGB\"";

fn frame(size: [f64; 2], axis: Option<ImagePoint>, faults: &mut Faults) -> Option<Frame> {
    let is_whole =
        |number: f64| number.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&number);
    let [width, height] = size;
    if !size.into_iter().all(is_whole) {
        let remedy = "give [width, height] of the full frame in whole pixels";
        faults.push("image_size", format!("is [{width},{height}]"), remedy);
        return None;
    }
    Frame::new(width as u32, height as u32, axis)
        .map_err(|error| faults.push(error.place, error.problem, error.remedy))
        .ok()
}

fn camera(keys: Map<String, Value>, faults: &mut Faults) -> Option<Camera> {
    let keys: CameraKeys = faults.parse("camera.", Value::Object(keys))?;
    Some(Camera {
        focal_length_mm: faults.positive(
            "camera.focal_length_mm",
            keys.focal_length_mm,
            "millimetres",
        ),
        f_number: faults.positive("camera.f_number", keys.f_number, "a number"),
        focus_distance: faults.distance("camera.focus_distance_m", keys.focus_distance_m),
        squeeze: faults.positive("camera.squeeze", keys.squeeze, "a number"),
        // Their range is checked with the rest of the set.
        wavelength_nm: keys.wavelength_nm,
        lens_model: keys.lens_model,
        lens_serial_number: keys.lens_serial_number,
    })
}
