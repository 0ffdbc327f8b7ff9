//! The lenses in use. All instances share them.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use seidel_core::{Lens, LibraryLens};
use seidel_optics::library::{self};

use super::{built_in, folder};
use crate::file_cache::FileCache;
use crate::host::{Failure, Result};

/// Largest lens profile that is read, bytes. Thousands of planes fit into a tenth of it.
const MAX_BYTES: u64 = 64 << 20;

/// The origin of a lens.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum LensOrigin {
    /// A lens profile in a file.
    File(String),
    /// A lens that comes with the plugin, by its index in the menu.
    BuiltIn(i32),
}

static LENSES: FileCache<LensOrigin, Lens> = FileCache::new();

/// Returns the lens of `origin`. A file is read again if it has changed, or if `reloads` has.
///
/// # Errors
/// A file that cannot be read or is not a lens profile. An older lens does not take its place.
pub(crate) fn load(origin: &LensOrigin, reloads: i32) -> Result<Arc<Lens>> {
    let own = match origin {
        LensOrigin::File(path) => own_file(path),
        LensOrigin::BuiltIn(_) => None,
    };
    let file = match origin {
        LensOrigin::File(path) => Some(own.as_deref().unwrap_or(Path::new(path))),
        LensOrigin::BuiltIn(_) => None,
    };
    LENSES.get(origin, file, reloads, || match origin {
        LensOrigin::File(path) => match &own {
            Some(own) => read(&own.to_string_lossy()),
            None => read(path),
        },
        LensOrigin::BuiltIn(index) => Ok(Lens::from_json(&built_in::profile(*index))?),
    })
}

/// Empties the cache. Lenses in use live on until they are dropped.
pub(crate) fn clear() {
    LENSES.clear();
}

/// Returns the file in the folder of own profiles that `path` names, unless there is a file or a lens of the library of that
/// name.
fn own_file(path: &str) -> Option<PathBuf> {
    let of_library = LibraryLens::by_reference(path).is_some_and(|found| found.is_ok());
    if Path::new(path).exists() || of_library {
        return None;
    }
    folder::file(&library::file_name(path)?)
}

/// Reads the lens profile in the file at `path`, or the lens of the library that `path` names where there is no such file.
fn read(path: &str) -> Result<Lens> {
    if !Path::new(path).exists()
        && let Some(found) = LibraryLens::by_reference(path)
    {
        let unknown =
            |e: seidel_core::Error| Failure::failed(format!("{path}: {}; {}", e.problem, e.remedy));
        return Ok(Lens::from_json(found.map_err(unknown)?.profile_json)?);
    }
    let unreadable = |error: std::io::Error| {
        Failure::failed(format!(
            "{path}: could not be read ({error}); check the path and its permissions"
        ))
    };
    let kind = std::fs::metadata(path).map_err(unreadable)?.file_type();
    if !(kind.is_file() || kind.is_dir()) {
        // Opening a pipe would wait for its writer.
        return Err(Failure::failed(format!(
            "{path}: is a pipe or a device, not a file; save its content in a file and give that"
        )));
    }
    let file = File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    // One byte more than allowed, which shows that a file is too long.
    file.take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(Failure::failed(format!(
            "{path}: is longer than {MAX_BYTES} bytes; check that it is a lens profile"
        )));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        Failure::failed(format!(
            "{path}: is not UTF-8 text (byte {}); give a lens profile that `seidel fit` wrote",
            error.utf8_error().valid_up_to()
        ))
    })?;
    Lens::from_json(&text).map_err(|error| Failure::failed(format!("{path}: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_is_found_by_name() {
        let named = |name: &str| load(&LensOrigin::File(name.to_owned()), 0);
        let lens = named("library:macro-100").expect("a lens of the library");
        assert_eq!(lens.profile().camera.focal_length_mm, Some(100.0));
        let unknown = named("library:makro-100").expect_err("no such lens");
        assert!(unknown.text.contains("library:macro-100"), "{unknown:?}");
    }

    #[test]
    fn files_are_read_again_when_they_change() {
        let folder = std::env::temp_dir().join(format!("seidel-ofx-cache-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("100% of a lens.json");
        let origin = LensOrigin::File(path.to_string_lossy().into_owned());
        let missing = load(&origin, 0).expect_err("no file");
        assert!(missing.text.contains("100% of a lens.json"), "{missing:?}");
        std::fs::write(&path, built_in::profile(1)).expect("written");
        let first = load(&origin, 0).expect("a lens");
        assert!(Arc::ptr_eq(&first, &load(&origin, 0).expect("cached")));
        assert!(!Arc::ptr_eq(&first, &load(&origin, 1).expect("reloaded")));
        std::fs::write(&path, built_in::profile(1) + "\n").expect("written");
        let changed = load(&origin, 1).expect("a lens");
        assert!(!Arc::ptr_eq(&first, &changed));
        std::fs::write(&path, "no lens").expect("written");
        assert!(load(&origin, 1).is_err());
        std::fs::remove_dir_all(&folder).expect("removed");
        assert!(load(&origin, 1).is_err(), "no lens outlives its file");
    }
}
