//! The keys of a manifest that describe one observation, those that `seidel measure` adds included.

use std::collections::BTreeMap;

use seidel_optics::field::ImagePoint;
use seidel_optics::observations::{ChannelMeasurement, Measurement, Observation};
use serde::Deserialize;
use serde_json::Value;

use super::faults::Faults;
use super::text::is_inside;
use crate::json::present;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a JSON object")]
struct Keys {
    file: String,
    x: f64,
    y: f64,
    #[serde(default, deserialize_with = "present")]
    depth_m: Option<Option<f64>>,
    ideal_x: Option<f64>,
    ideal_y: Option<f64>,
    #[serde(default)]
    noise_sigma: ByChannel,
    #[serde(default)]
    background: ByChannel,
    #[serde(default)]
    saturated: bool,
    gain: Option<f64>,
    weight_mask: Option<String>,
    #[serde(default)]
    source: String,
    centroid: Option<BTreeMap<String, [f64; 2]>>,
    #[serde(default)]
    centroid_sigma: ByChannel,
    #[serde(default)]
    flux: ByChannel,
    #[serde(default)]
    snr: ByChannel,
}

/// A number for all channels, or numbers by channel.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, or an object of numbers by channel"
)]
enum ByChannel {
    All(f64),
    Each(BTreeMap<String, f64>),
}

impl Default for ByChannel {
    fn default() -> Self {
        Self::Each(BTreeMap::new())
    }
}

impl ByChannel {
    fn of(&self, channel: &str) -> Option<f64> {
        match self {
            Self::All(number) => Some(*number),
            Self::Each(numbers) => numbers.get(channel).copied(),
        }
    }

    fn check(&self, field: &str, channels: &[String], faults: &mut Faults) {
        let Self::Each(numbers) = self else { return };
        for name in numbers.keys().filter(|name| !channels.contains(name)) {
            let problem = format!("names the channel `{name}`, which is not in the set");
            let remedy = format!("use the set's channels: {}", channels.join(", "));
            faults.push(field, problem, remedy);
        }
    }
}

/// Reads the keys of an observation, without its tiles and its weight mask; `None` if its JSON does not fit.
pub(super) fn read(value: Value, channels: &[String], faults: &mut Faults) -> Option<Observation> {
    let keys: Keys = faults.parse("", value)?;
    if !is_inside(&keys.file) {
        let problem = format!("is {:?}, which is not inside the set's folder", keys.file);
        let remedy = "put the tile in the folder and name it from there";
        faults.push("file", problem, remedy);
    }
    if let Some(name) = keys.weight_mask.as_ref().filter(|name| !is_inside(name)) {
        let remedy = "name a file of zeros and ones in the set's folder, or leave it out";
        faults.push("weight_mask", format!("is {name:?}"), remedy);
    }
    if keys.ideal_x.is_some() != keys.ideal_y.is_some() {
        let (stated, missing) = match keys.ideal_x {
            Some(_) => ("ideal_x", "ideal_y"),
            None => ("ideal_y", "ideal_x"),
        };
        faults.push(
            missing,
            format!("is missing beside {stated}"),
            "give both or none",
        );
    }
    keys.noise_sigma.check("noise_sigma", channels, faults);
    keys.background.check("background", channels, faults);
    let sigma = |name: &String| keys.noise_sigma.of(name);
    let noise_sigma: Vec<Option<f64>> = channels.iter().map(sigma).collect();
    if let Some(bad) = noise_sigma.iter().flatten().find(|sigma| **sigma < 0.0) {
        let remedy = "give a number that is not negative, or leave it out";
        faults.push("noise_sigma", format!("is {bad}"), remedy);
    }
    let background = |name: &String| keys.background.of(name).unwrap_or(0.0);
    Some(Observation {
        distance: faults.distance("depth_m", keys.depth_m),
        gain: faults.positive("gain", keys.gain, "counts per electron"),
        measurement: measurement(&keys, channels),
        centre: ImagePoint::new(keys.x, keys.y),
        ideal: (keys.ideal_x.zip(keys.ideal_y)).map(|(x, y)| ImagePoint::new(x, y)),
        tiles: Vec::new(),
        background: channels.iter().map(background).collect(),
        noise_sigma,
        saturated: keys.saturated,
        weight_mask: None,
        file: keys.file,
    })
}

/// Returns the figures of a measurement; `None` if the observation has no centroids.
fn measurement(keys: &Keys, channels: &[String]) -> Option<Measurement> {
    let centroids = keys.centroid.as_ref()?;
    let figures = |name: &String| {
        let [x_px, y_px] = *centroids.get(name)?;
        Some(ChannelMeasurement {
            centroid: ImagePoint::new(x_px, y_px),
            centroid_sigma_px: keys.centroid_sigma.of(name).unwrap_or(0.0),
            flux: keys.flux.of(name).unwrap_or(0.0),
            snr: keys.snr.of(name).unwrap_or(0.0),
        })
    };
    Some(Measurement {
        source: keys.source.clone(),
        channels: channels.iter().map(figures).collect(),
    })
}
