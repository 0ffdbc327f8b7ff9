//! The table of lens handles.
//!
//! A handle is a number in the form of a pointer and is never dereferenced. Numbers are not reused, so a released
//! handle is always recognised.

use std::collections::BTreeMap;
use std::ptr::without_provenance_mut;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use seidel_core::Lens;

use crate::status::{Failure, Result};

/// Handle of a lens. Any number of threads may use it at the same time.
#[derive(Debug)]
pub struct SeidelLens {
    _opaque: [u8; 0],
}

/// Difference between two handles: they look like pointers to aligned memory.
const STEP: usize = 16;

struct Entry {
    lens: Arc<Lens>,
    references: u64,
}

struct Table {
    last_handle: usize,
    entries: BTreeMap<usize, Entry>,
}

static TABLE: Mutex<Table> = Mutex::new(Table {
    last_handle: 0,
    entries: BTreeMap::new(),
});

fn table() -> MutexGuard<'static, Table> {
    // The table is consistent at every point where a thread can panic.
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unknown_handle() -> Failure {
    Failure::argument(
        "lens",
        "is not a handle, or was released",
        "give a handle from seidel_lens_open or seidel_lens_read",
    )
}

/// Adds a lens; returns its handle, with one reference.
pub(crate) fn insert(lens: Lens) -> *mut SeidelLens {
    let lens = Arc::new(lens);
    let mut table = table();
    table.last_handle += STEP;
    let handle = table.last_handle;
    let entry = Entry {
        lens,
        references: 1,
    };
    table.entries.insert(handle, entry);
    without_provenance_mut(handle)
}

/// Returns the lens of a handle. It outlives a release of the handle.
pub(crate) fn lens(handle: *const SeidelLens) -> Result<Arc<Lens>> {
    let table = table();
    let entry = table.entries.get(&handle.addr());
    Ok(Arc::clone(&entry.ok_or_else(unknown_handle)?.lens))
}

/// Adds a reference to a handle.
pub(crate) fn retain(handle: *const SeidelLens) -> Result<()> {
    let mut table = table();
    let entry = table.entries.get_mut(&handle.addr());
    entry.ok_or_else(unknown_handle)?.references += 1;
    Ok(())
}

/// Removes a reference from a handle; the last one removes the lens.
pub(crate) fn release(handle: *const SeidelLens) -> Result<()> {
    let mut table = table();
    let entry = table.entries.get_mut(&handle.addr());
    let entry = entry.ok_or_else(unknown_handle)?;
    entry.references -= 1;
    let removed = (entry.references == 0).then(|| table.entries.remove(&handle.addr()));
    // The lens is dropped after the lock.
    drop(table);
    drop(removed);
    Ok(())
}

/// Returns whether there is any handle.
pub(crate) fn any() -> bool {
    !table().entries.is_empty()
}
