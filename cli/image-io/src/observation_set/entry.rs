//! The keys of a manifest: those of the set and those of an observation.

use std::collections::BTreeMap;

use seidel_optics::camera::Camera;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Fault;
use seidel_optics::field::{Frame, ImagePoint};
use seidel_optics::mosaic::Mosaic;
use seidel_optics::observations::Measurement;
use serde_json::Value;

use super::fields::{Fields, abbreviated};
use super::{FORMAT, MOSAIC_VERSION, VERSION, measurement};

const SET_KEYS: [&str; 9] = [
    "format",
    "version",
    "image_size",
    "optical_axis",
    "pixel_pitch_um",
    "channels",
    "camera",
    "mosaic",
    "observations",
];

const CAMERA_KEYS: [&str; 5] = [
    "focal_length_mm",
    "f_number",
    "focus_distance_m",
    "wavelength_nm",
    "squeeze",
];

const OBSERVATION_KEYS: [&str; 11] = [
    "file",
    "x",
    "y",
    "depth_m",
    "ideal_x",
    "ideal_y",
    "noise_sigma",
    "background",
    "saturated",
    "gain",
    "weight_mask",
];

/// The entry of the set as a whole.
pub(super) struct SetEntry<'a> {
    pub(super) frame: Frame,
    pub(super) axis_stated: bool,
    pub(super) pixel_pitch_um: Option<f64>,
    pub(super) channels: Vec<String>,
    pub(super) camera: Camera,
    pub(super) mosaic: Option<Mosaic>,
    pub(super) observations: &'a [Value],
}

/// The entry of one observation, without its tile.
pub(super) struct ObservationEntry {
    pub(super) file: String,
    pub(super) centre: ImagePoint,
    pub(super) distance: ObjectDistance,
    pub(super) ideal: Option<ImagePoint>,
    pub(super) noise_sigma: Vec<Option<f64>>,
    pub(super) background: Vec<f64>,
    pub(super) saturated: bool,
    pub(super) gain: Option<f64>,
    pub(super) measurement: Option<Measurement>,
}

/// Reads the keys of the set; `None` if a fault prevents reading the observations.
pub(super) fn read_set<'a>(root: &'a Value, faults: &mut Vec<Fault>) -> Option<SetEntry<'a>> {
    let Some(object) = root.as_object() else {
        faults.push(not_an_object(root, None, "manifest"));
        return None;
    };
    let mut fields = Fields::new(object, "", None, faults);
    // A file of another format or version has other keys, so only this fault is reported.
    let format = fields.required("format", &format!("\"{FORMAT}\""))?;
    if format.as_str() != Some(FORMAT) {
        let remedy = format!("give a PSF observation set, whose format is \"{FORMAT}\"");
        fields.fault("format", format!("is {}", abbreviated(format)), remedy);
        return None;
    }
    let version = fields.required("version", &VERSION.to_string())?;
    let is_mosaic = version.as_u64() == Some(MOSAIC_VERSION);
    if !is_mosaic && version.as_u64() != Some(VERSION) {
        let remedy = format!(
            "only versions {VERSION} and {MOSAIC_VERSION} are read; write the set in one of them"
        );
        fields.fault("version", format!("is {}", abbreviated(version)), remedy);
        return None;
    }
    fields.check_keys(&SET_KEYS);
    let mosaic = mosaic(&mut fields, is_mosaic);
    let size = image_size(&mut fields);
    let axis = optical_axis(&mut fields);
    let axis_stated = fields.get("optical_axis").is_some();
    let pixel_pitch_um = fields.positive("pixel_pitch_um", "the pixel pitch in micrometres");
    let channels = channels(&mut fields);
    let observations = match fields.required("observations", "a list of observations") {
        Some(Value::Array(list)) => Some(list.as_slice()),
        Some(other) => {
            let problem = format!("is {}", abbreviated(other));
            fields.fault("observations", problem, "give a list of observations");
            None
        }
        None => None,
    };
    let frame = size.and_then(|(width, height)| match Frame::new(width, height, axis) {
        Ok(frame) => Some(frame),
        Err(error) => {
            fields.fault(&error.place, error.problem, error.remedy);
            None
        }
    });
    let camera = match object.get("camera") {
        None => Camera::default(),
        Some(Value::Object(map)) => camera(&mut fields.inside(map, "camera.")),
        Some(other) => {
            let problem = format!("is {}", abbreviated(other));
            fields.fault("camera", problem, "give an object, or leave it out");
            Camera::default()
        }
    };
    Some(SetEntry {
        frame: frame?,
        axis_stated,
        pixel_pitch_um,
        channels: channels?,
        camera,
        mosaic,
        observations: observations?,
    })
}

/// Reads the mosaic, which sets of [`MOSAIC_VERSION`] have and no others.
fn mosaic(fields: &mut Fields<'_, '_>, is_needed: bool) -> Option<Mosaic> {
    const WHAT: &str = "the colours of the frame's top-left 2 x 2 pixels, such as \"RGGB\"";
    let value = if is_needed {
        fields.required("mosaic", WHAT)?
    } else {
        let value = fields.get("mosaic")?;
        let remedy = format!("write the set as version {MOSAIC_VERSION}, or leave the key out");
        fields.fault(
            "mosaic",
            format!("is not a key of version {VERSION}"),
            remedy,
        );
        value
    };
    let parsed = value.as_str().and_then(|text| Mosaic::parse(text).ok());
    if parsed.is_none() {
        let problem = format!("is {}", abbreviated(value));
        fields.fault("mosaic", problem, format!("give {WHAT}"));
    }
    parsed
}

fn image_size(fields: &mut Fields<'_, '_>) -> Option<(u32, u32)> {
    const WHAT: &str = "[width, height] of the full frame in whole pixels";
    let value = fields.required("image_size", WHAT)?;
    let pixels = |value: &Value| {
        let number = value.as_f64()?;
        let whole = number.fract() == 0.0 && (1.0..=f64::from(u32::MAX)).contains(&number);
        whole.then_some(number as u32)
    };
    let pair = match value.as_array().map(Vec::as_slice) {
        Some([width, height]) => pixels(width).zip(pixels(height)),
        _ => None,
    };
    if pair.is_none() {
        fields.fault("image_size", format!("is {value}"), format!("give {WHAT}"));
    }
    pair
}

fn optical_axis(fields: &mut Fields<'_, '_>) -> Option<ImagePoint> {
    const REMEDY: &str = "give [x, y] in frame pixels, or leave it out for the frame's centre";
    let value = fields.get("optical_axis")?;
    let Some([x, y]) = value.as_array().map(Vec::as_slice) else {
        fields.fault("optical_axis", format!("is {}", abbreviated(value)), REMEDY);
        return None;
    };
    let x = fields.number_of("optical_axis", x, REMEDY);
    let y = fields.number_of("optical_axis", y, REMEDY);
    Some(ImagePoint::new(x?, y?))
}

fn channels(fields: &mut Fields<'_, '_>) -> Option<Vec<String>> {
    const WHAT: &str = "a list of image channel names, such as [\"R\", \"G\", \"B\"] or [\"Y\"]";
    let value = fields.required("channels", WHAT)?;
    let names: Option<Vec<String>> = value.as_array().and_then(|list| {
        let name = |v: &Value| Some(v.as_str().filter(|n| !n.is_empty())?.to_owned());
        list.iter().map(name).collect()
    });
    if names.is_none() {
        fields.fault(
            "channels",
            format!("is {}", abbreviated(value)),
            format!("give {WHAT}"),
        );
    }
    names
}

/// Reads a distance in metres: absent is unknown, null is infinity.
fn distance(fields: &mut Fields<'_, '_>, key: &str) -> ObjectDistance {
    const REMEDY: &str = "give metres greater than zero, null for infinity, or leave it out";
    let Some(value) = fields.get(key) else {
        return ObjectDistance::Unknown;
    };
    if value.is_null() {
        return ObjectDistance::Infinity;
    }
    let Some(metres) = fields.number_of(key, value, REMEDY) else {
        return ObjectDistance::Unknown;
    };
    ObjectDistance::metres(metres).unwrap_or_else(|error| {
        fields.fault(key, error.problem, REMEDY);
        ObjectDistance::Unknown
    })
}

fn camera(fields: &mut Fields<'_, '_>) -> Camera {
    fields.check_keys(&CAMERA_KEYS);
    let focal_length_mm = fields.positive("focal_length_mm", "millimetres");
    let f_number = fields.positive("f_number", "a number");
    let focus_distance = distance(fields, "focus_distance_m");
    let squeeze = fields.positive("squeeze", "a number");
    let mut wavelength_nm = BTreeMap::new();
    match fields.get("wavelength_nm") {
        None => {}
        Some(Value::Object(by_channel)) => {
            let mut fields = fields.inside(by_channel, "camera.wavelength_nm.");
            for channel in by_channel.keys() {
                if let Some(nm) = fields.positive(channel, "nanometres") {
                    wavelength_nm.insert(channel.clone(), nm);
                }
            }
        }
        Some(other) => fields.fault(
            "wavelength_nm",
            format!("is {}", abbreviated(other)),
            "give an object of nanometres by channel, or leave it out",
        ),
    }
    Camera {
        focal_length_mm,
        f_number,
        focus_distance,
        wavelength_nm,
        squeeze,
    }
}

fn not_an_object(value: &Value, observation: Option<usize>, field: &str) -> Fault {
    Fault {
        observation,
        file: String::new(),
        field: field.to_owned(),
        problem: format!("is {}", abbreviated(value)),
        remedy: "give a JSON object".to_owned(),
    }
}

/// Reads the keys of observation `index`; `None` if they have any fault.
pub(super) fn read_observation(
    value: &Value,
    index: usize,
    channels: &[String],
    faults: &mut Vec<Fault>,
) -> Option<ObservationEntry> {
    let before = faults.len();
    let Some(object) = value.as_object() else {
        faults.push(not_an_object(value, Some(index), "observation"));
        return None;
    };
    let mut fields = Fields::new(object, "", Some(index), faults);
    let known: Vec<&str> = (OBSERVATION_KEYS.iter())
        .chain(&measurement::KEYS)
        .copied()
        .collect();
    fields.check_keys(&known);
    let file = match fields.required("file", "the tile's path, relative to the manifest") {
        Some(Value::String(name)) if is_inside(name) => Some(name.clone()),
        Some(Value::String(name)) => {
            let problem = format!("is {:?}, which is not inside the set's folder", name);
            fields.fault(
                "file",
                problem,
                "put the tile in the folder and name it from there",
            );
            None
        }
        Some(other) => {
            fields.fault(
                "file",
                format!("is {}", abbreviated(other)),
                "give the tile's path",
            );
            None
        }
        None => None,
    };
    let x = fields.required_number("x", "the frame position of the tile's centre in pixels");
    let y = fields.required_number("y", "the frame position of the tile's centre in pixels");
    let distance = distance(&mut fields, "depth_m");
    let ideal = ideal(&mut fields);
    let noise = by_channel(&mut fields, "noise_sigma", channels);
    if let Some(&bad) = noise.iter().flatten().find(|&&sigma| sigma < 0.0) {
        let remedy = "give a number that is not negative, or leave it out";
        fields.fault("noise_sigma", format!("is {bad}"), remedy);
    }
    let background = by_channel(&mut fields, "background", channels);
    let saturated = match fields.get("saturated") {
        None => false,
        Some(Value::Bool(flag)) => *flag,
        Some(other) => {
            let problem = format!("is {}", abbreviated(other));
            fields.fault("saturated", problem, "give true or false, or leave it out");
            false
        }
    };
    let gain = fields.positive("gain", "counts per electron");
    let measurement = measurement::read(&mut fields, channels);
    if faults.len() > before {
        return None;
    }
    Some(ObservationEntry {
        file: file?,
        centre: ImagePoint::new(x?, y?),
        distance,
        ideal,
        noise_sigma: noise,
        background: background.iter().map(|b| b.unwrap_or(0.0)).collect(),
        saturated,
        gain,
        measurement,
    })
}

fn ideal(fields: &mut Fields<'_, '_>) -> Option<ImagePoint> {
    const WHAT: &str = "the position of the point with an undistorted lens, in frame pixels";
    let (x, y) = (
        fields.number("ideal_x", WHAT),
        fields.number("ideal_y", WHAT),
    );
    match (fields.get("ideal_x"), fields.get("ideal_y")) {
        (Some(_), None) => {
            fields.fault("ideal_y", "is missing beside ideal_x", "give both or none")
        }
        (None, Some(_)) => {
            fields.fault("ideal_x", "is missing beside ideal_y", "give both or none")
        }
        _ => {}
    }
    Some(ImagePoint::new(x?, y?))
}

/// Reads a number for all channels, or an object of numbers by channel; `None` for channels without one.
fn by_channel(fields: &mut Fields<'_, '_>, key: &str, channels: &[String]) -> Vec<Option<f64>> {
    const REMEDY: &str = "give a number, or an object of numbers by channel, or leave it out";
    let none = vec![None; channels.len()];
    match fields.get(key) {
        None => none,
        Some(Value::Object(map)) => {
            for name in map.keys().filter(|name| !channels.contains(name)) {
                let remedy = format!("use the set's channels: {}", channels.join(", "));
                fields.fault(
                    key,
                    format!("names the channel `{name}`, which is not in the set"),
                    remedy,
                );
            }
            channels
                .iter()
                .map(|name| fields.number_of(key, map.get(name)?, REMEDY))
                .collect()
        }
        Some(value) => match fields.number_of(key, value, REMEDY) {
            Some(number) => vec![Some(number); channels.len()],
            None => none,
        },
    }
}

/// Returns whether the name of a tile stays inside the folder of the set on every system.
pub(super) fn is_inside(name: &str) -> bool {
    let drive = name.as_bytes().get(1) == Some(&b':');
    let rooted = name.starts_with(['/', '\\']);
    let climbs = name.split(['/', '\\']).any(|part| part == "..");
    !name.is_empty() && !name.contains('\0') && !drive && !rooted && !climbs
}
