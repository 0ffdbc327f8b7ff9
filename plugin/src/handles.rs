//! Lenses that callers hold. A handle is a number in the guise of a pointer, never given twice: one that was released is
//! told from one that is held, and nobody's memory is read by it.

use std::collections::BTreeMap;
use std::ptr::without_provenance_mut;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::lens::{Lens, SeidelLens};
use crate::status::{Failure, Result};

struct Held {
    lens: Arc<Lens>,
    /// How many times it must be released.
    holds: u64,
}

struct Table {
    last: usize,
    held: BTreeMap<usize, Held>,
}

static TABLE: Mutex<Table> = Mutex::new(Table {
    last: 0,
    held: BTreeMap::new(),
});

fn table() -> MutexGuard<'static, Table> {
    // The table is whole wherever a thread may have died.
    TABLE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unknown() -> Failure {
    Failure::argument(
        "lens",
        "is not a handle that is held",
        "give one of seidel_lens_open or seidel_lens_read that was not released",
    )
}

/// A new handle, held once.
pub(crate) fn hold(lens: Lens) -> *mut SeidelLens {
    let mut table = table();
    table.last += 16;
    let number = table.last;
    let lens = Arc::new(lens);
    table.held.insert(number, Held { lens, holds: 1 });
    without_provenance_mut(number)
}

/// The lens of a handle; it lives on while this is kept, also where the handle is released.
pub(crate) fn lens(handle: *const SeidelLens) -> Result<Arc<Lens>> {
    let table = table();
    let held = table.held.get(&handle.addr()).ok_or_else(unknown)?;
    Ok(Arc::clone(&held.lens))
}

/// Holds a handle once more.
pub(crate) fn retain(handle: *const SeidelLens) -> Result<()> {
    let mut table = table();
    let held = table.held.get_mut(&handle.addr()).ok_or_else(unknown)?;
    held.holds += 1;
    Ok(())
}

/// Lets go of a handle once.
pub(crate) fn release(handle: *const SeidelLens) -> Result<()> {
    let mut table = table();
    let held = table.held.get_mut(&handle.addr()).ok_or_else(unknown)?;
    held.holds -= 1;
    let gone = (held.holds == 0).then(|| table.held.remove(&handle.addr()));
    // A lens is dropped outside the lock.
    drop(table);
    drop(gone);
    Ok(())
}

/// Whether any handle is held.
pub(crate) fn any() -> bool {
    !table().held.is_empty()
}
