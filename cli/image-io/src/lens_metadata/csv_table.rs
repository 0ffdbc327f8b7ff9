//! Tables of makers with a line a frame: their columns by name, and the values in their cells.

use std::path::Path;

use super::number::{self, Length};
use super::record::{FrameRecord, Quantity, Reading, UnitSource};
use super::time_code::TimeCode;
use crate::error::{FileError, Result};

/// Cells that stand for no value.
const NO_VALUE: [&str; 5] = ["", "--", "-", "n.a.", "N/A"];

/// A table with named columns.
pub(super) struct CsvTable<'a> {
    path: &'a Path,
    columns: Vec<String>,
    rows: Vec<csv::StringRecord>,
}

/// A row of a table.
pub(super) struct Row<'t> {
    table: &'t CsvTable<'t>,
    cells: &'t csv::StringRecord,
}

impl<'a> CsvTable<'a> {
    /// Parses `text`, which must have all columns of `needed`.
    pub(super) fn parse(
        path: &'a Path,
        text: &str,
        delimiter: u8,
        needed: &[&str],
    ) -> Result<Self> {
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(delimiter)
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let unreadable = |e: csv::Error| {
            let line = e.position().map_or(1, csv::Position::line);
            FileError::new(
                path,
                format!("line {line}"),
                format!("is not a whole row of the table: {e}"),
                "export the table again: it may be cut off",
            )
        };
        let columns = reader.headers().map_err(unreadable)?.iter();
        let columns: Vec<String> = columns.map(str::to_owned).collect();
        if let Some(missing) = needed
            .iter()
            .find(|name| !columns.iter().any(|c| c == *name))
        {
            return Err(FileError::new(
                path,
                format!("column `{missing}`"),
                "is missing: the table is of another version, or was exported without it",
                "export it with this column, or write the values into a table for --animate",
            ));
        }
        let rows = reader.records().map(|row| row.map_err(unreadable));
        Ok(Self {
            path,
            columns,
            rows: rows.collect::<Result<_>>()?,
        })
    }

    /// Returns the names of the columns.
    pub(super) fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Reads every row by `read`.
    pub(super) fn records(
        &self,
        read: impl Fn(&Row) -> Result<FrameRecord>,
    ) -> Result<Vec<FrameRecord>> {
        let rows = self.rows.iter();
        rows.map(|cells| read(&Row { table: self, cells }))
            .collect()
    }
}

impl Row<'_> {
    /// Returns a cell; `None` if it holds no value.
    pub(super) fn cell(&self, column: &str) -> Option<&str> {
        let at = self.table.columns.iter().position(|own| own == column)?;
        self.cells.get(at).filter(|cell| !NO_VALUE.contains(cell))
    }

    /// Returns the error about a cell.
    pub(super) fn fault(&self, column: &str, problem: &str, remedy: &str) -> FileError {
        let line = self.cells.position().map_or(0, csv::Position::line);
        let cell = self.cell(column).unwrap_or_default();
        FileError::new(
            self.table.path,
            format!("line {line}, column `{column}`"),
            format!("`{cell}` {problem}"),
            remedy,
        )
    }

    /// Returns a record with frame number, time code and identity, each from the column named.
    pub(super) fn record(
        &self,
        number: Option<&str>,
        time_code: &str,
        identity: &[(&'static str, &str)],
    ) -> Result<FrameRecord> {
        let frame = number.and_then(|column| Some((column, self.cell(column)?)));
        let frame = frame.map(|(column, cell)| {
            cell.parse()
                .map_err(|_| self.fault(column, "is not a frame number", "give a whole number"))
        });
        let code = self.cell(time_code).map(|cell| {
            TimeCode::parse(cell).ok_or_else(|| {
                self.fault(time_code, "is not a time code", "give it as hh:mm:ss:ff")
            })
        });
        let identity = identity.iter();
        let identity =
            identity.filter_map(|(words, column)| Some((*words, self.cell(column)?.to_owned())));
        Ok(FrameRecord {
            number: frame.transpose()?,
            time_code: code.transpose()?,
            identity: identity.collect(),
            ..FrameRecord::default()
        })
    }

    /// Reads a length of a cell in `unit` unless the cell names its own; nothing if the cell holds no value.
    pub(super) fn length(
        &self,
        quantity: Quantity,
        column: &str,
        unit: ColumnUnit,
    ) -> Result<Option<Reading>> {
        let Some(cell) = self.cell(column) else {
            return Ok(None);
        };
        let remedy = "give a number, with its unit if it is another";
        let Some(Length { value, unit: own }) = number::parse_length(cell) else {
            return Err(self.fault(column, "is not a number", remedy));
        };
        let (name, source) = match own {
            "" => (unit.name, unit.source),
            own => (own, UnitSource::Stated),
        };
        let Some(scale) = number::millimetres_per(name) else {
            let problem = format!("has the unit `{name}`, which is not known");
            return Err(self.fault(column, &problem, "give m, cm, mm, ft or in"));
        };
        let millimetres = value * scale;
        Ok(Some(Reading {
            quantity,
            value: number::decimal(match quantity {
                Quantity::Focus => millimetres / 1000.0,
                _ => millimetres,
            }),
            unit: source,
            is_t_stop: false,
            from_sensor: quantity == Quantity::Focus,
            field: format!("column `{column}`"),
            text: match own {
                "" => format!("{cell} {name}"),
                _ => cell.to_owned(),
            },
        }))
    }

    /// Reads an f-number or T-number of a cell; one without a letter is a T-number, as cameras show it.
    pub(super) fn stop(&self, column: &str) -> Result<Option<Reading>> {
        let Some(cell) = self.cell(column) else {
            return Ok(None);
        };
        let stop = number::parse_stop(cell).ok_or_else(|| {
            let remedy = "give a number, or a full stop with tenths such as 1.4 + 7/10";
            self.fault(column, "is not a stop", remedy)
        })?;
        Ok(Some(self.stop_reading(column, stop.value, stop.is_t_stop)))
    }

    /// Returns the reading of an f-number, or of a T-number unless `is_t_stop` is false.
    pub(super) fn stop_reading(
        &self,
        column: &str,
        value: f64,
        is_t_stop: Option<bool>,
    ) -> Reading {
        Reading {
            quantity: Quantity::FNumber,
            value,
            unit: UnitSource::Stated,
            is_t_stop: is_t_stop.unwrap_or(true),
            from_sensor: false,
            field: format!("column `{column}`"),
            text: self.cell(column).unwrap_or_default().to_owned(),
        }
    }
}

/// The unit of a column, and the place that states it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ColumnUnit<'t> {
    pub(super) name: &'t str,
    pub(super) source: UnitSource,
}

impl<'t> ColumnUnit<'t> {
    /// A unit that the format defines.
    pub(super) const fn defined(name: &'t str) -> Self {
        let source = UnitSource::Defined;
        Self { name, source }
    }

    /// A unit that the table names.
    pub(super) const fn stated(name: &'t str) -> Self {
        let source = UnitSource::Stated;
        Self { name, source }
    }
}
