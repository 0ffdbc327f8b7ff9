//! Lens profiles: JSON files, and the lenses of the library by name.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use seidel_optics::library::{self, LibraryLens};
use seidel_optics::profile::LensProfile;

use crate::atomic::write_atomically;
use crate::error::{FileError, Result};
use crate::format::detect;
use crate::json::{read_bytes, read_text};

/// Limit of the length of lens profiles, bytes. Thousands of planes fit into a tenth of it.
const LIMIT_BYTES: u64 = 64 << 20;

/// Reads a lens profile: a file, or a lens of the library named as `library:NAME` where there is no file of that name.
///
/// # Errors
/// A file that cannot be read or is not a valid profile; pictures and folders are named as what they are. A name that the
/// library lacks; the remedy has the nearest one.
pub fn read(path: &Path) -> Result<LensProfile> {
    if let Some(lens) = of_library(path)? {
        return lens.profile().map_err(|e| FileError::from_core(path, e));
    }
    refuse_other_kinds(path)?;
    let text = read_text(path, LIMIT_BYTES)?;
    LensProfile::from_json(&text).map_err(|e| FileError::from_core(path, e))
}

/// Returns the lens of the library that `path` names; `None` for the path of a file, also of one with such a name.
///
/// # Errors
/// A name that the library lacks.
pub fn of_library(path: &Path) -> Result<Option<&'static LibraryLens>> {
    let reference = path.to_str().filter(|_| !path.exists());
    let found = reference.and_then(library::by_reference).transpose();
    // The place of the error is the reference itself.
    found.map_err(|e| FileError::new(path, "", e.problem, e.remedy))
}

/// Returns the text of the file `path`, or that of the profile of the library that `path` names.
///
/// # Errors
/// A file that cannot be read or is longer than `limit_bytes`; a name that the library lacks.
pub(crate) fn file_or_library(path: &Path, limit_bytes: u64) -> Result<Cow<'static, [u8]>> {
    Ok(match of_library(path)? {
        Some(lens) => Cow::Borrowed(lens.profile_json.as_bytes()),
        None => Cow::Owned(read_bytes(path, limit_bytes)?),
    })
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
        "give the JSON file that `seidel fit` wrote, or library:NAME (`seidel lens list`)",
    ))
}

/// Writes a lens profile, whole or not at all.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, profile: &LensProfile) -> Result<()> {
    write_atomically(path, |out| out.write_all(profile.to_json().as_bytes()))
}
