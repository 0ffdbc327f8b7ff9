//! ARRI Meta Extract: tab-separated, with the unit of distances in a column of its own.

use std::path::Path;

use super::csv_table::{ColumnUnit, CsvTable, Row};
use super::number;
use super::record::{FrameRecord, Quantity};
use super::table_dialect::Dialect;
use crate::error::Result;

const DISTANCE: &str = "Lens Focus Distance";
const UNIT: &str = "Lens Distance Unit";
const FOCAL_LENGTH: &str = "Lens Focal Length";
const IRIS: &str = "Lens Iris";
const LINEAR_IRIS: &str = "Lens Linear Iris";

pub(super) static DIALECT: Dialect = Dialect {
    name: "ARRI Meta Extract",
    is_start: |text| text.contains("Master TC\t"),
    read,
};

fn read(path: &Path, text: &str) -> Result<Vec<FrameRecord>> {
    let needed = ["Master TC", UNIT, DISTANCE, FOCAL_LENGTH, IRIS];
    let table = CsvTable::parse(path, text, b'\t', &needed)?;
    table.records(record)
}

fn record(row: &Row) -> Result<FrameRecord> {
    let identity = [
        ("lens model", "Lens Model"),
        ("lens serial number", "Lens Serial Number"),
        ("camera model", "Camera Model"),
        ("camera serial number", "Camera Serial Number"),
    ];
    let mut record = row.record(Some("Index"), "Master TC", &identity)?;
    let unit = match row.cell(UNIT) {
        Some(unit) => unit,
        None if row.cell(DISTANCE).is_none() => "m",
        None => {
            let remedy = "put Meter or Feet into the column `Lens Distance Unit`";
            return Err(row.fault(DISTANCE, "has no unit", remedy));
        }
    };
    let focus = row.length(Quantity::Focus, DISTANCE, ColumnUnit::stated(unit))?;
    let unit = ColumnUnit::defined("mm");
    let focal_length = row.length(Quantity::FocalLength, FOCAL_LENGTH, unit)?;
    record
        .readings
        .extend(focus.into_iter().chain(focal_length));
    // The linear iris is finer than the tenths of a stop in the text.
    let linear = row.cell(LINEAR_IRIS).map(|cell| {
        let linear = number::parse(cell).filter(|linear| linear.is_finite());
        linear.ok_or_else(|| row.fault(LINEAR_IRIS, "is not a number", "give a whole number"))
    });
    let stop = match linear.transpose()? {
        Some(linear) => {
            let t_number = number::decimal(((linear - 1000.0) / 2000.0).exp2());
            Some(row.stop_reading(LINEAR_IRIS, t_number, Some(true)))
        }
        None => row.stop(IRIS)?,
    };
    record.readings.extend(stop);
    Ok(record)
}
