//! Pictures as raw files of single-precision numbers, and a synthetic one.

use crate::{SIDE, plate};
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

/// Returns names and samples of the pictures in `folder`, by name; a synthetic one without a folder.
pub(crate) fn all(folder: Option<&Path>) -> Result<Vec<(String, Vec<f32>)>> {
    let Some(folder) = folder else {
        return Ok(vec![(
            "drawn".to_owned(),
            plate::plate(SIDE, SIDE, 0.0).swap_remove(1),
        )]);
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|end| end == "f32")
            && let Some(name) = path.file_stem()
        {
            found.push((name.to_string_lossy().into_owned(), read(&path)?));
        }
    }
    found.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(found)
}

fn read(path: &Path) -> Result<Vec<f32>> {
    let bytes = std::fs::read(path)?;
    let (numbers, rest) = bytes.as_chunks::<4>();
    if numbers.len() != SIDE * SIDE || !rest.is_empty() {
        let problem = format!("{}: is not {SIDE} x {SIDE} samples", path.display());
        return Err(Error::new(ErrorKind::InvalidData, problem));
    }
    Ok(numbers.iter().map(|b| f32::from_le_bytes(*b)).collect())
}

/// Writes samples as little-endian single-precision numbers.
pub(crate) fn write(path: &Path, samples: &[f32]) -> Result<()> {
    let bytes: Vec<u8> = samples.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(path, bytes)
}
