//! Canon: the table of the frames. Distances are metres, written as the bits of a float; other values are fractions.

use std::path::Path;

use super::csv_table::{ColumnUnit, CsvTable, Row};
use super::number;
use super::record::{FrameRecord, Quantity, Reading, UnitSource};
use super::table_dialect::Dialect;
use crate::error::Result;

const DISTANCE: &str = "FocusPosition";
const FOCAL_LENGTH: &str = "FocalLength";
const STOP: &str = "ApertureNumber";
const STOP_MODE: &str = "ApertureMode";

pub(super) static DIALECT: Dialect = Dialect {
    name: "Canon",
    is_start: |text| {
        text.lines()
            .next()
            .is_some_and(|line| line.contains(DISTANCE))
    },
    read,
};

fn read(path: &Path, text: &str) -> Result<Vec<FrameRecord>> {
    let needed = ["Timecode", DISTANCE, FOCAL_LENGTH, STOP, STOP_MODE];
    CsvTable::parse(path, text, b',', &needed)?.records(record)
}

fn record(row: &Row) -> Result<FrameRecord> {
    let mut record = row.record(None, "Timecode", &[])?;
    if let Some(bits) = row.cell(DISTANCE) {
        let remedy = "give a float of 32 bits as eight hexadecimal digits";
        let value = number::parse_hexadecimal_float(bits)
            .ok_or_else(|| row.fault(DISTANCE, "is not the bits of a number", remedy))?;
        record.readings.push(Reading {
            quantity: Quantity::Focus,
            value,
            unit: UnitSource::Defined,
            is_t_stop: false,
            from_sensor: true,
            field: format!("column `{DISTANCE}`"),
            text: format!("{bits}, which is {value} m"),
        });
    }
    if is_stated(row, FOCAL_LENGTH) {
        let unit = ColumnUnit::defined("mm");
        let focal_length = row.length(Quantity::FocalLength, FOCAL_LENGTH, unit)?;
        record.readings.extend(focal_length);
    }
    if is_stated(row, STOP)
        && let Some(stop) = row.stop(STOP)?
    {
        // Mode 2 is a T-number, 1 an f-number.
        let is_t_stop = row.cell(STOP_MODE) != Some("1");
        record.readings.push(Reading { is_t_stop, ..stop });
    }
    Ok(record)
}

/// Returns whether a fraction states a value: equal terms of all ones stand for none.
fn is_stated(row: &Row, column: &str) -> bool {
    !matches!(
        row.cell(column),
        None | Some("65535/65535" | "4294967295/4294967295")
    )
}
