//! Messages that stand until what they are about is mended.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::host::{self, Host};
use crate::sys::Handle;

/// Instances of which something is told.
static TOLD: Mutex<BTreeSet<usize>> = Mutex::new(BTreeSet::new());

fn lock() -> MutexGuard<'static, BTreeSet<usize>> {
    // The set is whole wherever a thread may have died.
    TOLD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Tells the user of an instance what is wrong.
pub(crate) fn tell(host: &Host, handle: Handle, text: &str) {
    if text.is_empty() {
        return;
    }
    lock().insert(handle.addr());
    host::show_error(host, handle, text);
}

/// Knows nothing more of an instance; the host is not called.
pub(super) fn forget(handle: Handle) -> bool {
    lock().remove(&handle.addr())
}

/// Takes back what was told, where something was.
pub(crate) fn untell(host: &Host, handle: Handle) {
    if forget(handle) {
        host::clear_error(host, handle);
    }
}
