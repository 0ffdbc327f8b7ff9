//! `seidel.lens_settings`: the settings of the lens that a file states, by frame.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use seidel_core::Knob;
use seidel_image_io::lens_metadata::{
    Quantity, ShotRecord, ShotUse, Sidecar, columns, is_table, of_plate,
};

use crate::error::Result;

/// Adds the function to the module.
pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(lens_settings, module)?)
}

/// Returns focus distance, f-number, focal length and film back that a file states, with the names of `Settings`, a dictionary
/// for each frame.
///
/// `path` is an OpenEXR file, or a table that `--lens-metadata` of the command reads. Distances in scene units need
/// `metres_per_unit`. What a frame lacks is not in its dictionary.
///
/// Raises `FileError` for a file that cannot be read, and for values that cannot be true.
#[pyfunction]
#[pyo3(signature = (path, *, metres_per_unit=None))]
fn lens_settings(
    path: PathBuf,
    metres_per_unit: Option<f64>,
) -> Result<Vec<BTreeMap<String, f64>>> {
    let records = match is_table(&path) {
        true => Sidecar::open(&path)?.records().to_vec(),
        false => vec![of_plate(&path)?],
    };
    let records = records
        .into_iter()
        .zip(0..)
        .map(|(record, frame)| ShotRecord {
            frame,
            file: path.clone(),
            record,
        });
    let records: Vec<ShotRecord> = records.collect();
    let shot_use = ShotUse {
        metres_per_unit,
        focal_length_mm: None,
    };
    let mut frames = vec![BTreeMap::new(); records.len()];
    for column in columns(&records, &Quantity::ALL, shot_use)?.columns {
        let Some(knob) = Knob::named(column.quantity.knob()) else {
            continue;
        };
        for (frame, values) in (0..).zip(&mut frames) {
            if let Some(value) = column.values.get(&frame) {
                values.insert(knob.identifier(), *value);
            }
        }
    }
    Ok(frames)
}
