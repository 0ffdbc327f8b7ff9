//! Messages that hosts show until their cause is removed.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::host::{self, Host};
use crate::sys::Handle;

/// Instances that have a message.
static INSTANCES: Mutex<BTreeSet<usize>> = Mutex::new(BTreeSet::new());

fn lock() -> MutexGuard<'static, BTreeSet<usize>> {
    // No code panics halfway through a change of the set.
    INSTANCES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Shows an error of an instance.
pub(super) fn show(host: &Host, handle: Handle, text: &str) {
    if text.is_empty() {
        return;
    }
    lock().insert(handle.addr());
    host::show_error(host, handle, text);
}

/// Shows a warning of an instance, whose render is complete.
pub(super) fn warn(host: &Host, handle: Handle, text: &str) {
    if text.is_empty() {
        return;
    }
    lock().insert(handle.addr());
    host::show_warning(host, handle, text);
}

/// Forgets the message of an instance without a call of the host; returns whether there was one.
pub(super) fn forget(handle: Handle) -> bool {
    lock().remove(&handle.addr())
}

/// Clears the message of an instance, if it has one.
pub(super) fn clear(host: &Host, handle: Handle) {
    if forget(handle) {
        host::clear_message(host, handle);
    }
}
