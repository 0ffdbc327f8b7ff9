//! Sony VENICE: units stand in the names of the columns, feet among them.

use std::path::Path;

use super::csv_table::{ColumnUnit, CsvTable};
use super::record::{FrameRecord, Quantity};
use super::table_dialect::Dialect;
use crate::error::{FileError, Result};

const DISTANCE: &str = "Focus Distance (";
const FOCAL_LENGTH: &str = "Focal Length (";

pub(super) static DIALECT: Dialect = Dialect {
    name: "Sony",
    is_start: |text| {
        let line = text.lines().next().unwrap_or_default();
        line.contains("Clip Name") && line.contains("Timecode") && line.contains("Lens Model")
    },
    read,
};

fn read(path: &Path, text: &str) -> Result<Vec<FrameRecord>> {
    let table = CsvTable::parse(path, text, b',', &["Timecode", "Aperture"])?;
    let distance = column(path, &table, DISTANCE)?;
    let focal_length = column(path, &table, FOCAL_LENGTH)?;
    let identity = [
        ("lens model", "Lens Model"),
        ("lens serial number", "Lens Serial"),
        ("camera model", "Camera Model"),
    ];
    table.records(|row| {
        let mut record = row.record(None, "Timecode", &identity)?;
        let readings = [
            row.length(Quantity::Focus, distance, unit_of(distance))?,
            row.length(Quantity::FocalLength, focal_length, unit_of(focal_length))?,
            row.stop("Aperture")?,
        ];
        record.readings.extend(readings.into_iter().flatten());
        Ok(record)
    })
}

/// Returns the full name of the column that starts with `start`.
fn column<'t>(path: &Path, table: &'t CsvTable, start: &str) -> Result<&'t str> {
    let mut columns = table.columns().iter();
    let found = columns.find(|name| name.starts_with(start));
    found.map(String::as_str).ok_or_else(|| {
        FileError::new(
            path,
            format!("column `{start}unit)`"),
            "is missing",
            "export the table with the columns of the lens",
        )
    })
}

/// Returns the unit between the brackets of the name of a column.
fn unit_of(column: &str) -> ColumnUnit<'_> {
    let unit = column.rsplit('(').next().unwrap_or_default();
    ColumnUnit::stated(unit.trim_end_matches(')'))
}
