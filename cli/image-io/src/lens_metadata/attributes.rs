//! Lens and camera in the attributes of a plate, by the names of the programs that write them.

use std::path::Path;

use super::attribute_dialect::{Attributes, Dialect, Row, Unit};
use super::number;
use super::record::{FrameRecord, Quantity, Reading, UnitSource};
use super::time_code::TimeCode;
use super::{arnold, openexr, redshift, vray};
use crate::description::Description;
use crate::error::Result;
use crate::formats::{exr, row_of_file};
use crate::part::Part;

/// Every dialect: OpenEXR's own names are preferred to those of renderers.
static DIALECTS: [&Dialect; 4] = [
    &openexr::DIALECT,
    &vray::DIALECT,
    &redshift::DIALECT,
    &arnold::DIALECT,
];

/// Parts of the names of attributes that may concern the lens.
const LENS_WORDS: [&str; 7] = [
    "focus", "focal", "iris", "aperture", "fstop", "lens", "distance",
];

/// Returns the statements of a plate of any format.
///
/// # Errors
/// A file that cannot be read.
pub fn of_plate(path: &Path) -> Result<FrameRecord> {
    let description = Description::read(path)?;
    Ok(description.lens)
}

/// Returns the statements in the header of an EXR file; nothing for other formats, whose samples would have to be read.
///
/// # Errors
/// A file that cannot be read.
pub fn of_exr_header(path: &Path) -> Result<Option<FrameRecord>> {
    let (format, _) = row_of_file(path)?;
    if format != exr::FORMAT {
        return Ok(None);
    }
    of_plate(path).map(Some)
}

/// Returns the time code of a plate; `None` for one without, and for formats that have none.
///
/// # Errors
/// A file that cannot be read.
pub fn time_code(path: &Path) -> Result<Option<TimeCode>> {
    let (format, _) = row_of_file(path)?;
    if !format.capabilities.common_metadata {
        return Ok(None);
    }
    Ok(of_plate(path)?.time_code)
}

/// Returns the statements in the attributes of a file. The part that holds the beauty pass is preferred.
pub(crate) fn of_parts(parts: &[Part]) -> FrameRecord {
    let is_beauty = |part: &&Part| part.channels.iter().any(|(name, _)| name == "R");
    let beauty = parts.iter().find(is_beauty).or(parts.first());
    let is_other = |part: &&Part| !beauty.is_some_and(|beauty| std::ptr::eq(beauty, *part));
    let mut record = FrameRecord::default();
    for (index, part) in beauty
        .into_iter()
        .chain(parts.iter().filter(is_other))
        .enumerate()
    {
        let suffix = match &part.name {
            Some(name) if index > 0 => format!(" of part `{name}`"),
            _ => String::new(),
        };
        add_part(&Attributes { part, suffix }, &mut record);
    }
    record
}

fn add_part(attributes: &Attributes, record: &mut FrameRecord) {
    for dialect in DIALECTS {
        for row in dialect.rows {
            add_reading(attributes, row, record);
        }
        for (name, words) in dialect.identity {
            if let Some(text) = attributes.text(name).filter(|text| !text.is_empty()) {
                (record.identity.entry(words)).or_insert_with(|| text.to_owned());
            }
        }
        (dialect.combine)(attributes, record);
    }
    let storage = attributes.part.storage.iter();
    for (name, text) in attributes.part.attributes.iter().chain(storage) {
        if name == "timeCode" || name == "time code" {
            record.time_code = record.time_code.or_else(|| TimeCode::parse(text));
        }
    }
    let unread = attributes.part.attributes.iter().filter(|(name, _)| {
        let lower = name.to_ascii_lowercase();
        LENS_WORDS.iter().any(|word| lower.contains(word)) && !is_known(name)
    });
    let unread = unread.map(|(name, text)| (name.clone(), text.chars().take(60).collect()));
    record.unread.extend(unread);
}

/// Returns whether a dialect reads the attribute called `name`.
fn is_known(name: &str) -> bool {
    DIALECTS.iter().any(|dialect| {
        dialect.rows.iter().any(|row| row.name == name)
            || dialect.identity.iter().any(|(own, _)| *own == name)
    }) || openexr::COMBINED.contains(&name)
}

fn add_reading(attributes: &Attributes, row: &Row, record: &mut FrameRecord) {
    let Some(text) = attributes.text(row.name) else {
        return;
    };
    let field = attributes.field(row.name);
    let first = text.split_whitespace().next().unwrap_or_default();
    let new = |value, unit, text: String| Reading {
        quantity: row.quantity,
        value,
        unit,
        is_t_stop: row.unit == Unit::TNumber,
        from_sensor: row.unit == Unit::MetresFromSensor,
        text,
        field: field.clone(),
    };
    let reading = match row.unit {
        Unit::FNumber | Unit::TNumber => number::parse_stop(text)
            .map(|stop| new(stop.value, UnitSource::Defined, text.to_owned())),
        // Of a vector such as the size of the sensor, the first number is meant.
        _ => (number::parse_length(text).or_else(|| number::parse_length(first)))
            .and_then(|length| of_length(&length, row, first, new)),
    };
    // Shown and refused as it stands, if its use is requested.
    let unreadable = || new(f64::NAN, UnitSource::Defined, text.to_owned());
    record.readings.push(reading.unwrap_or_else(unreadable));
}

/// Returns the reading of a length. A unit that the text names replaces that of the row.
fn of_length(
    length: &number::Length,
    row: &Row,
    text: &str,
    new: impl Fn(f64, UnitSource, String) -> Reading,
) -> Option<Reading> {
    let (unit, words) = match row.unit {
        Unit::Scene => (UnitSource::Scene, "scene units"),
        Unit::MetresFromSensor => (UnitSource::Defined, "m"),
        _ => (UnitSource::Defined, "mm"),
    };
    if length.unit.is_empty() {
        return Some(new(length.value, unit, format!("{text} {words}")));
    }
    let millimetres = length.value * number::millimetres_per(length.unit)?;
    let value = number::decimal(match row.quantity {
        Quantity::Focus => millimetres / 1000.0,
        _ => millimetres,
    });
    let text = format!("{} {}", length.value, length.unit);
    Some(new(value, UnitSource::Stated, text))
}
