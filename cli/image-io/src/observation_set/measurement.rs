//! The keys that `seidel measure` adds to an observation: its photograph, and figures by channel.

use seidel_optics::error::Fault;
use seidel_optics::field::ImagePoint;
use seidel_optics::observations::{ChannelMeasurement, Measurement, Observation};
use serde_json::{Map, Value, json};

use super::fields::{Fields, is_inside};

/// The keys of this module.
pub(super) const KEYS: [&str; 5] = ["source", "centroid", "centroid_sigma", "flux", "snr"];

/// Reads the figures of a measurement; `None` if the observation has no centroids.
pub(super) fn read(fields: &mut Fields<'_, '_>, channels: &[String]) -> Option<Measurement> {
    let source = fields.parsed("source", "give the photograph's file name", Value::as_str);
    let remedy = "give an object of [x, y] by channel";
    let centroids = fields.parsed("centroid", remedy, Value::as_object)?;
    let figures = |fields: &mut Fields<'_, '_>, name: &str| -> Option<ChannelMeasurement> {
        let pair = centroids.get(name)?.as_array().map(Vec::as_slice);
        let centroid = match pair {
            Some([x, y]) => x.as_f64().zip(y.as_f64()),
            _ => None,
        };
        let Some((x_px, y_px)) = centroid else {
            let problem = format!("of channel {name} is not a pair of numbers");
            fields.fault("centroid", problem, "give [x, y] in frame pixels");
            return None;
        };
        let mut number = |key: &str| {
            let value = match fields.get(key) {
                Some(Value::Object(by_channel)) => by_channel.get(name)?,
                Some(value) => value,
                None => return None,
            };
            fields.number_of(
                key,
                value,
                "give a number, or an object of numbers by channel",
            )
        };
        Some(ChannelMeasurement {
            centroid: ImagePoint::new(x_px, y_px),
            centroid_sigma_px: number("centroid_sigma").unwrap_or(0.0),
            flux: number("flux").unwrap_or(0.0),
            snr: number("snr").unwrap_or(0.0),
        })
    };
    let channels = channels.iter().map(|name| figures(fields, name)).collect();
    Some(Measurement {
        source: source.unwrap_or_default().to_owned(),
        channels,
    })
}

/// Adds the figures of the measurement of `observation` to its entry.
pub(super) fn write(map: &mut Map<String, Value>, observation: &Observation, channels: &[String]) {
    let Some(measurement) = &observation.measurement else {
        return;
    };
    let by_channel = |value: &dyn Fn(&ChannelMeasurement) -> Value| -> Value {
        let pairs = channels.iter().zip(&measurement.channels);
        pairs
            .filter_map(|(name, m)| Some((name.clone(), value(m.as_ref()?))))
            .collect()
    };
    let mut put = |key: &str, value: Value| map.insert(key.to_owned(), value);
    put("source", json!(measurement.source));
    put(
        "centroid",
        by_channel(&|m| json!([m.centroid.x_px, m.centroid.y_px])),
    );
    put(
        "centroid_sigma",
        by_channel(&|m| json!(m.centroid_sigma_px)),
    );
    put("flux", by_channel(&|m| json!(m.flux)));
    put("snr", by_channel(&|m| json!(m.snr)));
}

/// Reads the name of the weight mask, a file inside the set's folder.
pub(super) fn weight_mask_name<'v>(
    value: &'v Value,
    index: usize,
    faults: &mut Vec<Fault>,
) -> Option<&'v str> {
    const REMEDY: &str = "name a file of zeros and ones in the set's folder, or leave it out";
    value.get("weight_mask")?;
    let mut fields = Fields::of_value(value, Some(index), "observation", faults)?;
    let inside = |value: &'v Value| value.as_str().filter(|name| is_inside(name));
    fields.parsed("weight_mask", REMEDY, inside)
}
