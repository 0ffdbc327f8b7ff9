//! Blackmagic RAW: text with a block a frame, and units beside the values.

use std::path::Path;

use super::number;
use super::record::{FrameRecord, Quantity, Reading, UnitSource};
use super::table_dialect::Dialect;
use super::time_code::TimeCode;
use crate::error::{FileError, Result};

pub(super) static DIALECT: Dialect = Dialect {
    name: "Blackmagic RAW",
    is_start: |text| {
        let mut lines = text.lines().map(str::trim);
        lines.any(|line| line == "Clip Metadata" || frame_of(line).is_some())
    },
    read,
};

/// Returns the number in the first line of a frame's block, such as `Frame 0 Metadata`.
fn frame_of(line: &str) -> Option<&str> {
    let rest = line.strip_prefix("Frame ")?;
    rest.strip_suffix(" Metadata").map(str::trim)
}

/// A line of the file.
struct Line<'t> {
    path: &'t Path,
    number: usize,
    name: &'t str,
    value: &'t str,
}

impl Line<'_> {
    fn fault(&self, problem: &str, remedy: &str) -> FileError {
        FileError::new(
            self.path,
            format!("line {}, `{}`", self.number, self.name),
            format!("`{}` {problem}", self.value),
            remedy,
        )
    }

    fn length(&self, quantity: Quantity) -> Result<Reading> {
        let remedy = "give a number with its unit, such as 991mm";
        let length = number::parse_length(self.value);
        let length = length.ok_or_else(|| self.fault("is not a number", remedy))?;
        let scale = match length.unit {
            "" if length.value.is_infinite() => Some(1.0),
            unit => number::millimetres_per(unit),
        };
        let scale = scale.ok_or_else(|| self.fault("has no known unit", remedy))?;
        let millimetres = length.value * scale;
        Ok(self.reading(
            quantity,
            number::decimal(match quantity {
                Quantity::Focus => millimetres / 1000.0,
                _ => millimetres,
            }),
        ))
    }

    fn stop(&self) -> Result<Reading> {
        let stop = number::parse_stop(self.value)
            .ok_or_else(|| self.fault("is not a stop", "give it as T2.3 or f/2.8"))?;
        Ok(Reading {
            is_t_stop: stop.is_t_stop.unwrap_or(true),
            ..self.reading(Quantity::FNumber, stop.value)
        })
    }

    fn reading(&self, quantity: Quantity, value: f64) -> Reading {
        Reading {
            quantity,
            value,
            unit: UnitSource::Stated,
            is_t_stop: false,
            from_sensor: quantity == Quantity::Focus,
            field: format!("`{}`", self.name),
            text: self.value.to_owned(),
        }
    }

    /// Adds the value of the line to the record of its frame.
    fn add_to(&self, record: &mut FrameRecord) -> Result<()> {
        if self.value.is_empty() {
            return Ok(());
        }
        match self.name {
            "distance" => record.readings.push(self.length(Quantity::Focus)?),
            "focal_length" => record.readings.push(self.length(Quantity::FocalLength)?),
            "aperture" => record.readings.push(self.stop()?),
            "timecode" => record.time_code = TimeCode::parse(self.value),
            _ => {}
        }
        Ok(())
    }
}

fn read(path: &Path, text: &str) -> Result<Vec<FrameRecord>> {
    let mut clip = FrameRecord::default();
    let mut records: Vec<FrameRecord> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(number) = frame_of(line) {
            let number = number.parse().map_err(|_| {
                FileError::new(
                    path,
                    format!("line {}", index + 1),
                    format!("`{number}` is not a frame number"),
                    "give a whole number",
                )
            })?;
            records.push(FrameRecord {
                number: Some(number),
                ..clip.clone()
            });
            continue;
        }
        let Some((name, value)) = line.split_once(':') else {
            continue;
        };
        let line = Line {
            path,
            number: index + 1,
            name: name.trim(),
            value: value.trim(),
        };
        match (records.last_mut(), line.name) {
            (Some(record), _) => line.add_to(record)?,
            (None, "lens_type") => {
                clip.identity.insert("lens model", line.value.to_owned());
            }
            (None, "camera_type") => {
                clip.identity.insert("camera model", line.value.to_owned());
            }
            (None, _) => {}
        }
    }
    Ok(records)
}
