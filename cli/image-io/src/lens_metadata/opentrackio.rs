//! OpenTrackIO (SMPTE RIS-OSVP): a sample, a stream or list of samples, or camdkit's clip, whose fields are lists by frame.

use std::path::Path;

use serde_json::Value;

use super::number;
use super::record::{FrameRecord, Quantity, Reading, UnitSource};
use super::table_dialect::Dialect;
use super::time_code::TimeCode;
use crate::error::{FileError, Result};

pub(super) static DIALECT: Dialect = Dialect {
    name: "OpenTrackIO",
    is_start: |text| text.trim_start().starts_with(['{', '[']),
    read,
};

/// Fields of values, with their quantity and unit.
const VALUES: [(&str, Quantity, &str); 4] = [
    ("/lens/focusDistance", Quantity::Focus, " m"),
    ("/lens/fStop", Quantity::FNumber, ""),
    ("/lens/tStop", Quantity::FNumber, ""),
    ("/lens/pinholeFocalLength", Quantity::FocalLength, " mm"),
];

/// Fields that do not change over a shot.
const FILM_BACK: &str = "/static/camera/activeSensorPhysicalDimensions/width";
const NOMINAL: &str = "/static/lens/nominalFocalLength";
const IDENTITY: [(&str, &str); 6] = [
    ("/static/lens/make", "lens make"),
    ("/static/lens/model", "lens model"),
    ("/static/lens/serialNumber", "lens serial number"),
    ("/static/camera/make", "camera make"),
    ("/static/camera/model", "camera model"),
    ("/static/camera/serialNumber", "camera serial number"),
];

const PUPIL: &str = "/lens/entrancePupilOffset";
const TIME_CODE: &str = "/timing/timecode";
const NUMBER: &str = "/timing/sequenceNumber";
const SOURCE: &str = "/sourceNumber";

fn read(path: &Path, text: &str) -> Result<Vec<FrameRecord>> {
    let mut samples = Vec::new();
    for value in serde_json::Deserializer::from_str(text).into_iter::<Value>() {
        match value {
            Ok(Value::Array(list)) => samples.extend(list),
            Ok(sample) => samples.push(sample),
            Err(e) => {
                return Err(FileError::new(
                    path,
                    format!("line {}, column {}", e.line(), e.column()),
                    format!("is not valid JSON: {e}"),
                    "export the samples again: the file may be cut off",
                ));
            }
        }
    }
    let mut records: Vec<FrameRecord> = Vec::new();
    let mut fixed = FrameRecord::default();
    let mut source = None;
    for (index, json) in samples.iter().enumerate() {
        let sample = Sample { path, index, json };
        sample.check_version()?;
        match (json.pointer(SOURCE), source) {
            (Some(own), Some(first)) if own != first => {
                let problem = format!("is {own}, but {first} in the first sample");
                return Err(sample.fault(SOURCE, &problem, "keep the samples of one camera"));
            }
            (Some(own), _) => source = source.or(Some(own)),
            (None, _) => {}
        }
        sample.add_fixed(&mut fixed)?;
        for entry in 0..sample.entries()? {
            records.push(sample.record(entry, &fixed)?);
        }
    }
    Ok(records)
}

/// An object of the file: a sample, or a clip of several.
struct Sample<'a> {
    path: &'a Path,
    index: usize,
    json: &'a Value,
}

impl Sample<'_> {
    fn fault(&self, field: &str, problem: &str, remedy: &str) -> FileError {
        let field = field.trim_start_matches('/').replace('/', ".");
        let place = format!("sample {}, {field}", self.index);
        FileError::new(self.path, place, problem, remedy)
    }

    /// Rejects other protocols, and versions whose fields have other meanings.
    fn check_version(&self) -> Result<()> {
        let remedy = "export OpenTrackIO of version 0.9 or 1";
        if !self.json.is_object() {
            return Err(self.fault("", "is not an object", remedy));
        }
        let first = |pointer| match self.json.pointer(pointer) {
            // A clip lists the protocol of every sample.
            Some(Value::Array(list)) if list.iter().any(Value::is_object) => list.first().cloned(),
            other => other.cloned(),
        };
        let Some(protocol) = first("/protocol") else {
            let has_fields = self.json.get("lens").is_some() || self.json.get("static").is_some();
            return match has_fields {
                true => Ok(()),
                false => Err(self.fault("protocol", "is missing, and so is lens", remedy)),
            };
        };
        if protocol.get("name").and_then(Value::as_str) != Some("OpenTrackIO") {
            return Err(self.fault("protocol.name", "is not OpenTrackIO", remedy));
        }
        let version = protocol.get("version");
        let numbers: Vec<String> = match version {
            Some(Value::Array(list)) => list.iter().map(Value::to_string).collect(),
            Some(Value::String(text)) => text.split('.').map(str::to_owned).collect(),
            _ => Vec::new(),
        };
        let is_known = match numbers.first().map(String::as_str) {
            Some("0") => numbers.get(1).is_some_and(|minor| minor == "9"),
            Some("1") => true,
            _ => false,
        };
        if is_known {
            return Ok(());
        }
        let version = version.map_or_else(|| "missing".to_owned(), Value::to_string);
        Err(self.fault(
            "protocol.version",
            &format!("is {version}, whose fields may have other units"),
            remedy,
        ))
    }

    /// Returns the number of frames of the object: 1 for a sample, the length of its lists for a clip.
    fn entries(&self) -> Result<usize> {
        let varying = VALUES.map(|(pointer, ..)| pointer);
        let varying = varying.into_iter().chain([PUPIL, TIME_CODE, NUMBER]);
        let lists = varying.filter_map(|pointer| {
            let list = self.json.pointer(pointer)?.as_array()?;
            Some((pointer, list.len()))
        });
        let lists: Vec<(&str, usize)> = lists.collect();
        let Some((first, count)) = lists.first() else {
            return Ok(1);
        };
        if let Some((other, own)) = lists.iter().find(|(_, own)| own != count) {
            let problem = format!("has {own} values, but {first} has {count}");
            return Err(self.fault(other, &problem, "export the clip again: it may be cut off"));
        }
        Ok(*count)
    }

    /// Returns the value of a field for an entry of a clip; that of the sample otherwise.
    fn value(&self, pointer: &str, entry: usize) -> Option<&Value> {
        let value = match self.json.pointer(pointer)? {
            Value::Array(list) => list.get(entry)?,
            value => value,
        };
        (!value.is_null()).then_some(value)
    }

    fn number(&self, pointer: &str, entry: usize) -> Result<Option<f64>> {
        let Some(value) = self.value(pointer, entry) else {
            return Ok(None);
        };
        let number = value.as_f64().filter(|number| number.is_finite());
        let number = number.ok_or_else(|| {
            let problem = format!("is {value}, not a number");
            self.fault(pointer, &problem, "give a number, or leave the field out")
        });
        number.map(Some)
    }

    /// Replaces what holds for all samples by the values that this one has.
    fn add_fixed(&self, fixed: &mut FrameRecord) -> Result<()> {
        for (pointer, words) in IDENTITY {
            if let Some(text) = self.json.pointer(pointer).and_then(Value::as_str) {
                fixed.identity.insert(words, text.to_owned());
            }
        }
        let fields = [
            (NOMINAL, Quantity::FocalLength),
            (FILM_BACK, Quantity::FilmBack),
        ];
        for (pointer, quantity) in fields {
            if let Some(value) = self.number(pointer, 0)? {
                fixed
                    .readings
                    .retain(|reading| reading.quantity != quantity);
                fixed
                    .readings
                    .push(reading(pointer, quantity, value, " mm"));
            }
        }
        Ok(())
    }

    fn record(&self, entry: usize, fixed: &FrameRecord) -> Result<FrameRecord> {
        let mut record = FrameRecord {
            number: self.value(NUMBER, entry).and_then(Value::as_i64),
            time_code: self.value(TIME_CODE, entry).and_then(time_code),
            identity: fixed.identity.clone(),
            ..FrameRecord::default()
        };
        for (pointer, quantity, unit) in VALUES {
            if let Some(value) = self.number(pointer, entry)? {
                record
                    .readings
                    .push(reading(pointer, quantity, value, unit));
            }
        }
        record.readings.extend(fixed.readings.iter().cloned());
        let pupil_m = self.number(PUPIL, entry)?;
        record.entrance_pupil_mm = pupil_m.map(|pupil| number::decimal(pupil * 1000.0));
        Ok(record)
    }
}

fn reading(pointer: &str, quantity: Quantity, value: f64, unit: &str) -> Reading {
    Reading {
        quantity,
        value,
        unit: UnitSource::Defined,
        is_t_stop: pointer.ends_with("tStop"),
        from_sensor: quantity == Quantity::Focus,
        field: pointer.trim_start_matches('/').replace('/', "."),
        text: format!("{value}{unit}"),
    }
}

fn time_code(value: &Value) -> Option<TimeCode> {
    let digit = |name| u16::try_from(value.get(name)?.as_u64()?).ok();
    TimeCode::new([
        digit("hours")?,
        digit("minutes")?,
        digit("seconds")?,
        digit("frames")?,
    ])
}
