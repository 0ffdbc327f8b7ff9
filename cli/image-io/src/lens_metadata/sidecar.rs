//! Tables of lens settings beside a shot, with the dialect recognised by the first lines.

use std::path::{Path, PathBuf};

use super::record::FrameRecord;
use super::table_dialect::Dialect;
use super::{arri, blackmagic, canon, opentrackio, red, sony};
use crate::error::{FileError, Result};
use crate::json::read_text;

/// Limit of the length of a table, bytes.
const LIMIT_BYTES: u64 = 256 * 1024 * 1024;

/// Length of the start of a file that identifies its dialect, characters.
const START: usize = 8192;

/// Extensions of tables.
const EXTENSIONS: [&str; 5] = ["csv", "json", "jsonl", "tsv", "txt"];

/// Returns whether a path has an extension of tables, not of pictures.
pub fn is_table(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|own| {
        EXTENSIONS
            .iter()
            .any(|table| own.eq_ignore_ascii_case(table))
    })
}

/// Every dialect.
static DIALECTS: [&Dialect; 6] = [
    &opentrackio::DIALECT,
    &arri::DIALECT,
    &red::DIALECT,
    &sony::DIALECT,
    &canon::DIALECT,
    &blackmagic::DIALECT,
];

/// A table of lens settings by frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Sidecar {
    path: PathBuf,
    dialect: &'static str,
    records: Vec<FrameRecord>,
}

impl Sidecar {
    /// Reads OpenTrackIO JSON or the table of a maker of cameras.
    ///
    /// # Errors
    /// A file that cannot be read or is of no known kind, values that are not numbers, and a file without values.
    pub fn open(path: &Path) -> Result<Self> {
        let text = read_text(path, LIMIT_BYTES)?;
        let start: String = text.chars().take(START).collect();
        let dialect = DIALECTS.iter().find(|dialect| (dialect.is_start)(&start));
        let Some(dialect) = dialect else {
            let names: Vec<&str> = DIALECTS.iter().map(|dialect| dialect.name).collect();
            return Err(FileError::new(
                path,
                "",
                "is no table of lens settings that is known",
                format!("give one of {}", names.join(", ")),
            ));
        };
        let records = (dialect.read)(path, &text)?;
        if records.iter().all(|record| record.readings.is_empty()) {
            return Err(FileError::new(
                path,
                "",
                format!("holds no lens settings by frame ({})", dialect.name),
                "export the table of the frames, with the columns of the lens",
            ));
        }
        Ok(Self {
            path: path.to_owned(),
            dialect: dialect.name,
            records,
        })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the kind of the file in words.
    pub fn dialect(&self) -> &'static str {
        self.dialect
    }

    /// Returns its frames in the order of the file.
    pub fn records(&self) -> &[FrameRecord] {
        &self.records
    }
}
