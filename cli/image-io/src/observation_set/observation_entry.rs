//! The keys of a manifest that describe one observation.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::Fault;
use seidel_optics::field::ImagePoint;
use seidel_optics::observations::Measurement;
use serde_json::Value;

use super::fields::{Fields, is_inside};
use super::measurement;

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

/// Reads the keys of observation `index`; `None` if they have any fault.
pub(super) fn read(
    value: &Value,
    index: usize,
    channels: &[String],
    faults: &mut Vec<Fault>,
) -> Option<ObservationEntry> {
    let before = faults.len();
    let mut fields = Fields::of_value(value, Some(index), "observation", faults)?;
    let known = OBSERVATION_KEYS.iter().chain(&measurement::KEYS);
    fields.check_keys(&known.copied().collect::<Vec<_>>());
    let file = file(&mut fields);
    let x = fields.required_number("x", "the frame position of the tile's centre in pixels");
    let y = fields.required_number("y", "the frame position of the tile's centre in pixels");
    let distance = fields.distance("depth_m");
    let ideal = ideal(&mut fields);
    let noise_sigma = by_channel(&mut fields, "noise_sigma", channels);
    if let Some(&bad) = noise_sigma.iter().flatten().find(|&&sigma| sigma < 0.0) {
        let remedy = "give a number that is not negative, or leave it out";
        fields.fault("noise_sigma", format!("is {bad}"), remedy);
    }
    let background = by_channel(&mut fields, "background", channels);
    let remedy = "give true or false, or leave it out";
    let saturated = fields.parsed("saturated", remedy, Value::as_bool);
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
        noise_sigma,
        background: background.iter().map(|b| b.unwrap_or(0.0)).collect(),
        saturated: saturated.unwrap_or(false),
        gain,
        measurement,
    })
}

/// Reads the path of the tile, which is inside the set's folder.
fn file(fields: &mut Fields<'_, '_>) -> Option<String> {
    fields.required("file", "the tile's path, relative to the manifest")?;
    let name = fields.parsed("file", "give the tile's path", Value::as_str)?;
    if is_inside(name) {
        return Some(name.to_owned());
    }
    let problem = format!("is {name:?}, which is not inside the set's folder");
    let remedy = "put the tile in the folder and name it from there";
    fields.fault("file", problem, remedy);
    None
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
