//! Lens profiles as JSON files.

use std::io::Write;
use std::path::Path;

use seidel_optics::profile::LensProfile;

use crate::atomic::write_atomically;
use crate::error::{FileError, Result};
use crate::format::detect;
use crate::json::read_text;

/// Limit of the length of lens profiles, bytes. Thousands of planes fit into a tenth of it.
const LIMIT_BYTES: u64 = 64 << 20;

/// Reads a lens profile.
///
/// # Errors
/// A file that cannot be read or is not a valid profile; pictures and folders are named as what they are.
pub fn read(path: &Path) -> Result<LensProfile> {
    refuse_other_kinds(path)?;
    let text = read_text(path, LIMIT_BYTES)?;
    LensProfile::from_json(&text).map_err(|e| FileError::from_core(path, e))
}

/// # Errors
/// A folder or a picture.
fn refuse_other_kinds(path: &Path) -> Result<()> {
    let kind = if path.join("manifest.json").is_file() {
        "an observation set".to_owned()
    } else if path.is_dir() {
        "a folder".to_owned()
    } else if let Ok(format) = detect(path) {
        format!("a picture ({format})")
    } else {
        return Ok(());
    };
    Err(FileError::new(
        path,
        "",
        format!("is {kind}, not a lens profile"),
        "give the JSON file that `seidel fit` wrote",
    ))
}

/// Writes a lens profile, whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, profile: &LensProfile) -> Result<()> {
    write_atomically(path, |out| out.write_all(profile.to_json().as_bytes()))
}
