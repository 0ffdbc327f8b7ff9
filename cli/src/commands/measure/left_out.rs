//! `left_out.json`: what was not measured, with the reason.

use std::path::Path;

use seidel_image_io::error::FileError;
use seidel_image_io::json::read_json;
use seidel_measure::{LeftOut, Photograph};
use serde_json::{Value, json};

/// Name of the file in the folder of a set.
pub(super) const FILE: &str = "left_out.json";

/// Returns the entries of `left_out`.
pub(super) fn entries(left_out: &[LeftOut], photographs: &[Photograph]) -> Vec<Value> {
    let rounded = |v: f64| (v * 1e4).round() / 1e4;
    let entry = |l: &LeftOut| {
        let mut entry = json!({
            "source": photographs[l.photograph].name,
            "x": rounded(l.x),
            "y": rounded(l.y),
            "why": l.why.name(),
            "value": rounded(l.value),
            "limit": rounded(l.limit),
        });
        if let Some(number) = l.number {
            entry["number"] = json!(number);
        }
        entry
    };
    left_out.iter().map(entry).collect()
}

/// Returns the entries of the set in `folder`; none if it has no such file.
pub(super) fn of_set(folder: &Path) -> Result<Vec<Value>, FileError> {
    let path = folder.join(FILE);
    if path.is_file() {
        read_json(&path)
    } else {
        Ok(Vec::new())
    }
}
