//! Pointers and handles that plugins pass to suite functions.

use std::ffi::{CStr, c_char};
use std::sync::Arc;

use openfx::sys::generic::core::*;

use crate::host::{HandleTarget, Host, current};

/// Returns the string at `text`, or nothing for NULL.
///
/// # Safety
/// `text` must be NULL or point to a terminated string that stays valid for `'a`.
pub(super) unsafe fn c_str<'a>(text: *const c_char) -> Option<&'a CStr> {
    if text.is_null() {
        None
    } else {
        // SAFETY: not NULL, so it points to a string.
        Some(unsafe { CStr::from_ptr(text) })
    }
}

/// Copies the string at `text`; empty for NULL.
///
/// # Safety
/// `text` must be NULL or point to a terminated string.
pub(super) unsafe fn string(text: *const c_char) -> String {
    // SAFETY: guaranteed by the caller.
    unsafe { c_str(text) }.map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

/// Writes a result to `to`; NULL is misuse.
///
/// # Safety
/// `to` must be NULL or point to memory for a `T`.
pub(super) unsafe fn write_result<T>(to: *mut T, value: T, call: &str) -> OfxStatus {
    if to.is_null() {
        if let Some(host) = current() {
            host.record_misuse(format!("{call} was given NULL for a result"));
        }
        return kOfxStatErrValue;
    }
    // SAFETY: guaranteed by the caller; hosts assume no alignment.
    unsafe { to.write_unaligned(value) };
    kOfxStatOK
}

/// Writes an optional result to `to`, unless it is NULL.
///
/// # Safety
/// `to` must be NULL or point to memory for a `T`.
pub(super) unsafe fn write_optional<T>(to: *mut T, value: T) {
    if !to.is_null() {
        // SAFETY: guaranteed by the caller.
        unsafe { to.write_unaligned(value) };
    }
}

/// Returns the active host and the object of a handle.
pub(super) fn resolve<T: HandleTarget>(
    handle: usize,
    call: &str,
) -> Result<(Arc<Host>, Arc<T>), OfxStatus> {
    let host = current().ok_or(kOfxStatFailed)?;
    let object = host.find::<T>(handle, call).ok_or(kOfxStatErrBadHandle)?;
    Ok((host, object))
}

/// Calls `work` with the active host and the object of a handle. Returns its status, or an error for invalid handles.
pub(super) fn with_object<T: HandleTarget>(
    handle: usize,
    call: &str,
    work: impl FnOnce(&Host, &Arc<T>) -> OfxStatus,
) -> OfxStatus {
    match resolve(handle, call) {
        Ok((host, object)) => work(&host, &object),
        Err(status) => status,
    }
}

/// Calls `work` with the active host. Returns its status, or failure if no host is active.
pub(super) fn with_host(work: impl FnOnce(&Host) -> OfxStatus) -> OfxStatus {
    current().map_or(kOfxStatFailed, |host| work(&host))
}
