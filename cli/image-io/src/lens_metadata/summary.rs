//! Statements about lens and camera in words, for `seidel info` and notes.

use std::collections::BTreeMap;

use super::record::{FrameRecord, Quantity, Reading, UnitSource};
use super::shot::{ShotUse, optics, range};

/// Returns the lines of a description: a name and a value each.
pub fn lines(record: &FrameRecord) -> Vec<(String, String)> {
    let mut lines = Vec::new();
    for reading in &record.readings {
        let fault =
            optics(record, ShotUse::default()).check(reading.quantity, reading.value, reading.unit);
        let fault = fault.filter(|_| reading.unit != UnitSource::Scene);
        let doubt = fault.map_or_else(String::new, |fault| {
            format!("; doubtful: it {}", fault.problem)
        });
        let name = match reading.is_t_stop {
            true => "T-number",
            false => reading.quantity.name(),
        };
        lines.push((
            name.to_owned(),
            format!("{}, from {}{doubt}", value_text(reading), reading.field),
        ));
    }
    if let Some(pupil_mm) = record.entrance_pupil_mm {
        let text = format!("{} before the sensor", Quantity::FocalLength.text(pupil_mm));
        lines.push(("entrance pupil".to_owned(), text));
    }
    let identity = record.identity.iter();
    lines.extend(identity.map(|(name, text)| ((*name).to_owned(), text.clone())));
    lines.extend(
        record
            .notes
            .iter()
            .map(|note| ("not used".to_owned(), note.clone())),
    );
    let unread = record.unread.iter();
    lines.extend(
        unread.map(|(name, text)| ("not read".to_owned(), format!("attribute `{name}`: {text}"))),
    );
    lines
}

/// Formats a value in the unit of its quantity, and as the file writes it where that differs.
fn value_text(reading: &Reading) -> String {
    if reading.unit == UnitSource::Scene || reading.value.is_nan() {
        return reading.text.clone();
    }
    let value = reading.quantity.text(reading.value);
    match value == reading.text {
        true => value,
        false => format!("{value} ({})", reading.text),
    }
}

/// Returns a short sentence part about the `wanted` quantities, such as "focus 3.2 m, f/2.8"; `None` if the file states none of them
/// plausibly.
pub fn knowledge(record: &FrameRecord, wanted: &[Quantity]) -> Option<String> {
    let stated = wanted.iter().filter_map(|quantity| {
        let reading = (record.preferred(*quantity, None))
            .or_else(|| record.preferred(*quantity, Some(1.0)))?;
        let doubt = optics(record, ShotUse::default())
            .check(*quantity, reading.value, reading.unit)
            .filter(|_| reading.unit != UnitSource::Scene);
        let doubt = doubt.map_or("", |_| " (doubtful)");
        let text = value_text(reading);
        Some(match quantity {
            Quantity::Focus => format!("focus {text}{doubt}"),
            Quantity::FNumber if reading.is_t_stop => format!("T{}{doubt}", reading.value),
            Quantity::FNumber => format!("f/{text}{doubt}"),
            Quantity::FocalLength => format!("focal length {text}{doubt}"),
            Quantity::FilmBack => format!("film back {text}{doubt}"),
        })
    });
    let stated: Vec<String> = stated.collect();
    (!stated.is_empty()).then(|| stated.join(", "))
}

/// Returns the range of each value over the records of several frames.
pub fn range_lines(records: &[FrameRecord]) -> Vec<String> {
    let mut values: BTreeMap<(Quantity, &str), Vec<&Reading>> = BTreeMap::new();
    for reading in records.iter().flat_map(|record| &record.readings) {
        let key = (reading.quantity, reading.field.as_str());
        values.entry(key).or_default().push(reading);
    }
    let line = |((quantity, field), readings): (&(Quantity, &str), &Vec<&Reading>)| {
        let range = range(*quantity, readings.iter().map(|r| r.value), readings.len());
        let unit = match readings[0].unit {
            UnitSource::Scene => " (scene units)",
            _ => "",
        };
        // A table may hold a column twice.
        let missing = match records.len().saturating_sub(readings.len()) {
            0 => String::new(),
            count => format!(", missing in {count}"),
        };
        let first = value_text(readings[0]);
        format!(
            "{}: {first} in the first frame, {range}{unit}{missing}, from {field}",
            quantity.name()
        )
    };
    values.iter().map(line).collect()
}
