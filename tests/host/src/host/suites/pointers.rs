//! Pointers that plugins hand over.

use std::ffi::{CStr, c_char};
use std::sync::Arc;

use openfx::sys::generic::core::*;

use crate::host::{Host, Kept, current};

/// The string there, nothing for NULL.
///
/// # Safety
/// `at` must be NULL or point to a string that ends in a zero and stays for `'a`.
pub(super) unsafe fn name<'a>(at: *const c_char) -> Option<&'a CStr> {
    if at.is_null() {
        None
    } else {
        // SAFETY: by the caller's word.
        Some(unsafe { CStr::from_ptr(at) })
    }
}

/// The string there as text, empty for NULL.
///
/// # Safety
/// As for `name`.
pub(super) unsafe fn text(at: *const c_char) -> String {
    // SAFETY: by the caller's word.
    unsafe { name(at) }.map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}

/// Writes a value; NULL is a misuse.
///
/// # Safety
/// `at` must be NULL or point to where a `T` may be written.
pub(super) unsafe fn put<T>(at: *mut T, value: T, call: &str) -> OfxStatus {
    if at.is_null() {
        if let Some(host) = current() {
            host.misused(format!("{call} was given NULL for a result"));
        }
        return kOfxStatErrValue;
    }
    // SAFETY: by the caller's word; hosts assume no alignment of what they are given.
    unsafe { at.write_unaligned(value) };
    kOfxStatOK
}

/// Writes a value, unless to NULL, which means that nobody wants it.
///
/// # Safety
/// As for `put`.
pub(super) unsafe fn put_if<T>(at: *mut T, value: T) {
    if !at.is_null() {
        // SAFETY: by the caller's word.
        unsafe { at.write_unaligned(value) };
    }
}

/// The host whose turn it is, and what the handle stands for.
pub(super) fn found<T: Kept>(handle: usize, call: &str) -> Result<(Arc<Host>, Arc<T>), OfxStatus> {
    let host = current().ok_or(kOfxStatFailed)?;
    let object = host.find::<T>(handle, call).ok_or(kOfxStatErrBadHandle)?;
    Ok((host, object))
}

/// The status of what was tried.
pub(super) fn status(tried: Result<(), OfxStatus>) -> OfxStatus {
    tried.err().unwrap_or(kOfxStatOK)
}
