//! Lens profiles as JSON files.

use std::io::Write;
use std::path::Path;

use seidel_optics::profile::LensProfile;

use crate::atomic::write_atomically;
use crate::error::{FileError, Result};
use crate::json::read_text;

/// Limit of the length of lens profiles, bytes. Thousands of planes fit into a tenth of it.
const LIMIT_BYTES: u64 = 64 << 20;

/// Reads a lens profile.
///
/// # Errors
/// A file that cannot be read or is not a valid profile.
pub fn read(path: &Path) -> Result<LensProfile> {
    let text = read_text(path, LIMIT_BYTES)?;
    LensProfile::from_json(&text).map_err(|e| FileError::from_core(path, e))
}

/// Writes a lens profile, whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, profile: &LensProfile) -> Result<()> {
    write_atomically(path, |out| out.write_all(profile.to_json().as_bytes()))
}
