//! Lenses that were read, by what they were read from. All instances share them.

use std::ffi::CString;
use std::path::Path;
use std::ptr::null_mut;
use std::sync::Arc;

use seidel_c::{SeidelLens, seidel_lens_open, seidel_lens_read, seidel_lens_release};

use super::{Info, built_in};
use crate::ffi;
use crate::host::{Failure, Result};
use crate::kept::Shelf;

/// Which lens.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Choice {
    /// That of a profile.
    File(String),
    /// One that comes with the plugin, by its place in the menu.
    BuiltIn(i32),
}

/// A lens that is held until it is dropped.
#[derive(Debug)]
pub(crate) struct Lens {
    handle: *mut SeidelLens,
    pub(crate) info: Info,
}

// SAFETY: a handle is a number; any number of threads may use it at once.
unsafe impl Send for Lens {}
// SAFETY: as above.
unsafe impl Sync for Lens {}

impl Drop for Lens {
    fn drop(&mut self) {
        // SAFETY is none to speak of: handles are numbers. This one is held once, by this.
        seidel_lens_release(self.handle);
    }
}

impl Lens {
    /// The handle, good as long as this is.
    pub(crate) fn handle(&self) -> *const SeidelLens {
        self.handle
    }

    fn held(handle: *mut SeidelLens) -> Result<Self> {
        match Info::of(handle) {
            Ok(info) => Ok(Self { handle, info }),
            Err(failure) => {
                seidel_lens_release(handle);
                Err(failure)
            }
        }
    }

    fn open(path: &str) -> Result<Self> {
        let text = CString::new(path)
            .map_err(|_| Failure::failed("Lens File: the path has a zero in it; give another"))?;
        let mut handle = null_mut();
        // SAFETY: a text with a zero at its end, and a place for a handle.
        ffi::done(unsafe { seidel_lens_open(text.as_ptr(), &raw mut handle) })?;
        Self::held(handle)
    }

    fn read(json: &str) -> Result<Self> {
        let mut handle = null_mut();
        let (text, length) = (json.as_ptr().cast(), json.len());
        // SAFETY: as many bytes as are said, and a place for a handle.
        ffi::done(unsafe { seidel_lens_read(text, length, &raw mut handle) })?;
        Self::held(handle)
    }
}

static KEPT: Shelf<Choice, Lens> = Shelf::new();

/// The lens of a choice: read again where its file is another than it was, or where `reloads` is.
///
/// # Errors
/// A file that cannot be read, or is no lens profile; the last lens that it held is not used in its place.
pub(crate) fn lens(choice: &Choice, reloads: i32) -> Result<Arc<Lens>> {
    let file = match choice {
        Choice::File(path) => Some(Path::new(path)),
        Choice::BuiltIn(_) => None,
    };
    KEPT.get(choice, file, reloads, || match choice {
        Choice::File(path) => Lens::open(path),
        Choice::BuiltIn(index) => Lens::read(&built_in::profile(*index)),
    })
}

/// Lets go of all; those in use live on until they are not.
pub(crate) fn forget() {
    KEPT.forget();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_read_again_when_they_change() {
        let folder = std::env::temp_dir().join(format!("seidel-ofx-cache-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("100% of a lens.json");
        let choice = Choice::File(path.to_string_lossy().into_owned());
        let missing = lens(&choice, 0).expect_err("no file");
        assert!(missing.text.contains("100% of a lens.json"), "{missing:?}");
        std::fs::write(&path, built_in::profile(1)).expect("written");
        let first = lens(&choice, 0).expect("a lens");
        assert!(Arc::ptr_eq(&first, &lens(&choice, 0).expect("kept")));
        assert!(!Arc::ptr_eq(&first, &lens(&choice, 1).expect("read again")));
        std::fs::write(&path, built_in::profile(1) + "\n").expect("written");
        let changed = lens(&choice, 1).expect("a lens");
        assert!(!Arc::ptr_eq(&first, &changed));
        std::fs::write(&path, "no lens").expect("written");
        assert!(lens(&choice, 1).is_err());
        std::fs::remove_dir_all(&folder).expect("removed");
        assert!(lens(&choice, 1).is_err(), "no lens outlives its file");
    }
}
