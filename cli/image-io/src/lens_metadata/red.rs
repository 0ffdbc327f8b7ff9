//! RED: the table by frame of REDline, print mode 5. Distances are millimetres.

use std::path::Path;

use super::csv_table::{ColumnUnit, CsvTable, Row};
use super::record::{FrameRecord, Quantity};
use super::table_dialect::Dialect;
use crate::error::Result;

pub(super) static DIALECT: Dialect = Dialect {
    name: "RED REDline",
    is_start: |text| text.starts_with("FrameNo,") || text.starts_with("Clip Name,File Path,"),
    read,
};

fn read(path: &Path, text: &str) -> Result<Vec<FrameRecord>> {
    let needed = [
        "FrameNo",
        "Timecode",
        "Aperture",
        "Focus Distance",
        "Focal Length",
    ];
    CsvTable::parse(path, text, b',', &needed)?.records(record)
}

fn record(row: &Row) -> Result<FrameRecord> {
    let mut record = row.record(Some("FrameNo"), "Timecode", &[])?;
    let unit = ColumnUnit::defined("mm");
    let readings = [
        row.length(Quantity::Focus, "Focus Distance", unit)?,
        row.length(Quantity::FocalLength, "Focal Length", unit)?,
        row.stop("Aperture")?,
    ];
    record.readings.extend(readings.into_iter().flatten());
    Ok(record)
}
