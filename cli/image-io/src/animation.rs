//! Animation tables: values by frame, from CSV or JSON.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::{FileError, Result};
use crate::json::read_text;

/// Limit of the length of a table, bytes.
const LIMIT_BYTES: u64 = 64 * 1024 * 1024;

/// Named values that change from frame to frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    path: PathBuf,
    /// The values of each name by frame.
    curves: BTreeMap<String, BTreeMap<i64, f64>>,
}

/// The interpolation between the values of two frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear in the value.
    Linear,
    /// Linear in the reciprocal of the value, for distances up to infinity.
    Reciprocal,
}

impl Animation {
    /// Reads a table: CSV with a column `frame` and one for each name, in which cells may be empty; or JSON, an object
    /// of objects such as `{"1001": {"name": 1.5}}`. Values are numbers or `inf`.
    ///
    /// # Errors
    /// A file that cannot be read or is neither, invalid frames and values, and a table without values.
    pub fn open(path: &Path) -> Result<Self> {
        let text = read_text(path, LIMIT_BYTES)?;
        let cells = if text.trim_start().starts_with('{') {
            json_cells(path, &text)?
        } else {
            csv_cells(path, &text)?
        };
        let mut curves: BTreeMap<String, BTreeMap<i64, f64>> = BTreeMap::new();
        for cell in cells {
            let curve = curves.entry(cell.name.clone()).or_default();
            if curve.insert(cell.frame, cell.value).is_some() {
                return Err(FileError::new(
                    path,
                    format!("frame {}, {}", cell.frame, cell.name),
                    "is given twice",
                    "give each frame one row",
                ));
            }
        }
        if curves.is_empty() {
            return Err(FileError::new(
                path,
                "",
                "contains no values",
                "give a CSV table with a column `frame` and one for each option",
            ));
        }
        Ok(Self {
            path: path.to_owned(),
            curves,
        })
    }

    /// Creates a table from the values of each name by frame; `path` is the file that errors name.
    pub fn from_curves(path: &Path, curves: BTreeMap<String, BTreeMap<i64, f64>>) -> Self {
        Self {
            path: path.to_owned(),
            curves,
        }
    }

    /// Returns whether every name has the same value in all frames.
    pub fn is_constant(&self) -> bool {
        self.curves.values().all(|curve| {
            let mut values = curve.values();
            let first = values.next();
            values.all(|value| Some(value) == first)
        })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns all names that have values.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.curves.keys().map(String::as_str)
    }

    /// Returns the value of `name` at `frame`, interpolated between frames that have one, and constant before the first
    /// and after the last. `None` if no frame has one.
    pub fn value(&self, name: &str, frame: i64, interpolation: Interpolation) -> Option<f64> {
        interpolate(self.curves.get(name)?, frame, interpolation)
    }
}

/// Returns the value at `frame` of values by frame, as [`Animation::value`] does.
pub(crate) fn interpolate(
    curve: &BTreeMap<i64, f64>,
    frame: i64,
    interpolation: Interpolation,
) -> Option<f64> {
    let before = curve.range(..=frame).next_back();
    let after = curve.range(frame..).next();
    let ((from, a), (to, b)) = match (before, after) {
        (Some(before), Some(after)) => (before, after),
        (Some(only), None) | (None, Some(only)) => (only, only),
        (None, None) => return None,
    };
    if from == to || a == b {
        return Some(*a);
    }
    // In floats, because the difference of two frame numbers may exceed an i64.
    let share = (frame as f64 - *from as f64) / (*to as f64 - *from as f64);
    let mix = |a: f64, b: f64| {
        let mixed = a + share * (b - a);
        // The difference of infinite values is no number, their weighted sum is.
        if mixed.is_nan() {
            (1.0 - share) * a + share * b
        } else {
            mixed
        }
    };
    Some(match interpolation {
        Interpolation::Linear => mix(*a, *b),
        Interpolation::Reciprocal => 1.0 / mix(1.0 / a, 1.0 / b),
    })
}

/// A value of a frame.
struct Cell {
    frame: i64,
    name: String,
    value: f64,
}

fn number(path: &Path, frame: i64, name: &str, text: &str) -> Result<f64> {
    let value = text.trim().parse::<f64>().ok().filter(|v| !v.is_nan());
    value.ok_or_else(|| {
        FileError::new(
            path,
            format!("frame {frame}, {name}"),
            format!("`{text}` is not a number"),
            "give a number, or inf",
        )
    })
}

fn frame_number(path: &Path, place: &str, text: &str) -> Result<i64> {
    text.trim().parse().map_err(|_| {
        FileError::new(
            path,
            place,
            format!("`{text}` is not a frame number"),
            "give a whole number",
        )
    })
}

fn json_cells(path: &Path, text: &str) -> Result<Vec<Cell>> {
    type Frames = BTreeMap<String, BTreeMap<String, serde_json::Value>>;
    let frames: Frames = serde_json::from_str(text).map_err(|e| {
        FileError::new(
            path,
            format!("line {}, column {}", e.line(), e.column()),
            format!("is not a valid table: {e}"),
            "write it like {\"1001\": {\"amount\": 1.5}}",
        )
    })?;
    let mut cells = Vec::new();
    for (frame, values) in frames {
        let frame = frame_number(path, "key", &frame)?;
        for (name, value) in values {
            let text = value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned);
            let value = number(path, frame, &name, &text)?;
            cells.push(Cell { frame, name, value });
        }
    }
    Ok(cells)
}

fn csv_cells(path: &Path, text: &str) -> Result<Vec<Cell>> {
    let refuse =
        |place: String, problem: String, remedy: &str| FileError::new(path, place, problem, remedy);
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let unreadable = |e: csv::Error| {
        let line = e.position().map_or(1, csv::Position::line);
        refuse(
            format!("line {line}"),
            format!("is not a valid table: {e}"),
            "give every row as many cells as the first",
        )
    };
    let header = reader.headers().map_err(unreadable)?.clone();
    let Some(frames) = header.iter().position(|name| name == "frame") else {
        return Err(refuse(
            "line 1".to_owned(),
            "has no column `frame`".to_owned(),
            "begin with a line such as frame,amount,focus-distance",
        ));
    };
    let mut cells = Vec::new();
    for row in reader.records() {
        let row = row.map_err(unreadable)?;
        let line = row.position().map_or(0, csv::Position::line);
        let frame = frame_number(path, &format!("line {line}"), &row[frames])?;
        for (column, (name, text)) in header.iter().zip(&row).enumerate() {
            if column != frames && !text.is_empty() {
                cells.push(Cell {
                    frame,
                    name: name.to_owned(),
                    value: number(path, frame, name, text)?,
                });
            }
        }
    }
    Ok(cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(text: &str) -> Result<Animation> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("values");
        std::fs::write(&path, text).expect("writable");
        Animation::open(&path)
    }

    #[test]
    fn values_between_infinity_or_zero_and_others_are_numbers() {
        let table = opened("frame,focus-distance\n1,0\n3,2\n5,inf\n").expect("sound");
        let value = |frame, by| table.value("focus-distance", frame, by);
        assert_eq!(value(2, Interpolation::Reciprocal), Some(0.0));
        assert_eq!(value(4, Interpolation::Reciprocal), Some(4.0));
        assert_eq!(value(4, Interpolation::Linear), Some(f64::INFINITY));
        let falling = opened("frame,focus-distance\n1,inf\n3,2\n").expect("sound");
        let value = falling.value("focus-distance", 2, Interpolation::Linear);
        assert_eq!(value, Some(f64::INFINITY));
    }

    #[test]
    fn values_are_interpolated_between_frames_and_constant_beyond() {
        let csv =
            opened("# a rack\nframe, focus-distance, amount\n10, 2, 0.5\n14, inf,\n20, 2, 1\n");
        let json = opened(
            r#"{"10": {"focus-distance": 2, "amount": 0.5}, "14": {"focus-distance": "inf"},
                "20": {"focus-distance": 2.0, "amount": 1}}"#,
        );
        for table in [csv.expect("sound"), json.expect("sound")] {
            let amount = |frame| table.value("amount", frame, Interpolation::Linear);
            assert_eq!([10, 15, 20].map(amount), [Some(0.5), Some(0.75), Some(1.0)]);
            assert_eq!([-3, 99].map(amount), [Some(0.5), Some(1.0)]);
            let focus = |frame| table.value("focus-distance", frame, Interpolation::Reciprocal);
            assert_eq!(focus(12), Some(4.0));
            assert_eq!(focus(14), Some(f64::INFINITY));
            assert_eq!(focus(17), Some(4.0));
            assert_eq!(table.value("f-number", 12, Interpolation::Linear), None);
            assert_eq!(
                table.names().collect::<Vec<_>>(),
                ["amount", "focus-distance"]
            );
        }
    }

    #[test]
    fn invalid_tables_are_refused_by_place() {
        for (text, expected) in [
            ("", "frame"),
            ("amount\n1\n", "frame"),
            ("frame,amount\n", "no values"),
            ("frame,amount\n1,2,3\n", "line 2"),
            ("frame,amount\nx,2\n", "`x` is not a frame"),
            ("frame,amount\n1,much\n", "frame 1, amount"),
            ("frame,amount\n1,nan\n", "not a number"),
            ("frame,amount\n1,1\n1,2\n", "given twice"),
            ("{\"1\": 3}", "line 1"),
            ("{\"one\": {\"amount\": 3}}", "`one` is not a frame"),
            ("{\"1\": {\"amount\": null}}", "not a number"),
        ] {
            let message = opened(text).expect_err(text).to_string();
            assert!(message.contains(expected), "{text}: {message}");
        }
    }

    /// Sound tables to damage. Their frames are as far apart as can be.
    const SOUND: [&str; 2] = [
        "# comment\nframe,amount,f-number\n-9223372036854775808,1,2.8\n9223372036854775807,2,inf\n",
        "{\"-9223372036854775808\": {\"amount\": 1}, \"9223372036854775807\": {\"amount\": \"inf\"}}",
    ];

    proptest::proptest! {
        #[test]
        fn damaged_tables_are_read_or_refused_with_a_remedy(
            which in 0..SOUND.len(),
            changes in proptest::collection::vec(
                (proptest::prelude::any::<proptest::sample::Index>(),
                 proptest::sample::select(b"\"{}[]:,.-0e9nN#\n \xff".to_vec())), 0..6),
            frame in proptest::prelude::any::<i64>(),
        ) {
            let mut bytes = SOUND[which].as_bytes().to_vec();
            for (at, byte) in changes {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("values");
            std::fs::write(&path, bytes).expect("writable");
            match Animation::open(&path) {
                Ok(table) => {
                    for name in table.names() {
                        let value = table.value(name, frame, Interpolation::Linear);
                        proptest::prop_assert!(value.is_some());
                    }
                }
                Err(error) => {
                    let message = error.to_string();
                    proptest::prop_assert!(message.contains("values") && message.contains("; "), "{}", message);
                }
            }
        }
    }
}
