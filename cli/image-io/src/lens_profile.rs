//! Lens profiles: JSON files, and the lenses of the library by name.

use std::borrow::Cow;
use std::io::Write;
use std::path::{Path, PathBuf};

use seidel_optics::library::{self, LibraryLens};
use seidel_optics::profile::LensProfile;

use crate::atomic::write_atomically;
use crate::error::{FileError, Result};
use crate::formats::detect;
use crate::json::{read_bytes, read_text};

/// Limit of the length of lens profiles, bytes. Thousands of planes fit into a tenth of it.
const LIMIT_BYTES: u64 = 64 << 20;

/// Reads a lens profile: a file, or a lens named as `library:NAME` where there is no file of that name. The library comes
/// first, then the folder that `SEIDEL_LENSES` names.
///
/// # Errors
/// A file that cannot be read or is not a valid profile; pictures and folders are named as what they are. A name that the
/// library lacks; the remedy has the nearest one.
pub fn read(path: &Path) -> Result<LensProfile> {
    if let Some(lens) = of_library(path)? {
        return lens.profile().map_err(|e| FileError::from_core(path, e));
    }
    let file = resolved(path);
    refuse_other_kinds(&file)?;
    let text = read_text(&file, LIMIT_BYTES)?;
    LensProfile::from_json(&text).map_err(|e| FileError::from_core(file.as_ref(), e))
}

/// Returns the folder of own profiles, if one is named.
fn own_folder() -> Option<PathBuf> {
    let folder = std::env::var_os(library::FOLDER_VARIABLE)?;
    (!folder.is_empty()).then(|| PathBuf::from(folder))
}

/// Returns the file in the folder of own profiles that `path` names by `library:`, or `path` itself.
fn resolved(path: &Path) -> Cow<'_, Path> {
    let own = own_folder().and_then(|folder| own_file(path, &folder));
    own.map_or(Cow::Borrowed(path), Cow::Owned)
}

/// Returns the file in `folder` that `path` names by `library:`; `None` for the path of a file, and for a lens of the library.
fn own_file(path: &Path, folder: &Path) -> Option<PathBuf> {
    let reference = path.to_str().filter(|_| !path.exists())?;
    let file = folder.join(library::file_name(reference)?);
    let of_library = LibraryLens::by_reference(reference).is_some_and(|found| found.is_ok());
    (file.is_file() && !of_library).then_some(file)
}

/// Returns the names of the profiles in the folder that `SEIDEL_LENSES` names, as `library:` takes them, in their order; none
/// without the variable.
///
/// # Errors
/// A folder that cannot be read.
pub fn own_names() -> Result<Vec<String>> {
    own_folder().map_or(Ok(Vec::new()), |folder| names_in(&folder))
}

fn names_in(folder: &Path) -> Result<Vec<String>> {
    let unreadable = |e: std::io::Error| {
        let remedy = format!("correct {}, or leave it out", library::FOLDER_VARIABLE);
        FileError::new(folder, "", format!("cannot be read: {e}"), remedy)
    };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let name = entry.map_err(unreadable)?.file_name();
        let name = name.to_str().and_then(|name| name.strip_suffix(".json"));
        names.extend(name.map(str::to_owned));
    }
    names.sort();
    Ok(names)
}

/// Returns the lens of the library that `path` names; `None` for the path of a file, also of one with such a name.
///
/// # Errors
/// A name that the library lacks.
pub fn of_library(path: &Path) -> Result<Option<&'static LibraryLens>> {
    let reference = path.to_str().filter(|_| !path.exists());
    let reference = reference.filter(|_| matches!(resolved(path), Cow::Borrowed(_)));
    let found = reference.and_then(LibraryLens::by_reference).transpose();
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
        None => Cow::Owned(read_bytes(&resolved(path), limit_bytes)?),
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
/// A file that cannot be written, and a profile that no file can hold.
pub fn write(path: &Path, profile: &LensProfile) -> Result<()> {
    (profile.check_storable()).map_err(|e| FileError::from_core(path, e))?;
    write_atomically(path, |out| out.write_all(profile.to_json().as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn profiles_of_a_folder_are_found_by_name_after_those_of_the_library() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        for name in ["ours.json", "macro-100.json", "notes.txt"] {
            std::fs::write(folder.join(name), "").expect("writable");
        }
        assert_eq!(names_in(folder).expect("readable"), ["macro-100", "ours"]);
        let found = |reference: &str| own_file(Path::new(reference), folder);
        assert_eq!(found("library:ours"), Some(folder.join("ours.json")));
        for other in [
            "library:macro-100",
            "library:notes",
            "ours",
            "library:../ours",
        ] {
            assert_eq!(found(other), None, "{other}");
        }
        let error = names_in(&folder.join("none")).expect_err("no folder");
        assert!(error.to_string().contains("SEIDEL_LENSES"), "{error}");
    }
}
