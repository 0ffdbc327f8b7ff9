//! What users and logs are told. Texts are never formats: a `%` in the name of a file is no more than that.

use std::ffi::{CStr, CString};

use super::Host;
use crate::sys::Handle;
use crate::sys::message::{ERROR, LOG, MESSAGE};

/// What all formats are.
const TEXT: &CStr = c"%s";
/// Identifier of messages.
const ID: &CStr = c"seidel";

/// Most bytes of a text.
const MOST: usize = 4000;

fn printable(text: &str) -> CString {
    let whole: String = text.chars().filter(|c| *c != '\0').collect();
    let mut end = whole.len().min(MOST);
    while !whole.is_char_boundary(end) {
        end -= 1;
    }
    CString::new(&whole[..end]).unwrap_or_default()
}

/// Tells the user of the instance behind `handle` what is wrong, until [`clear`] where the host can.
pub(crate) fn tell(host: &Host, handle: Handle, text: &str) {
    let messages = &host.suites.messages;
    let Some(message) = messages.set_persistent.or(messages.message) else {
        return;
    };
    let text = printable(text);
    // SAFETY: the host vouches for its function; the format takes one text.
    unsafe {
        message(
            handle,
            ERROR.as_ptr(),
            ID.as_ptr(),
            TEXT.as_ptr(),
            text.as_ptr(),
        )
    };
}

/// Takes back what was told.
pub(crate) fn clear(host: &Host, handle: Handle) {
    // Resolve 14 has the function without its being one (openfx-misc, README-hosts).
    if host.is_resolve() {
        return;
    }
    if let Some(clear) = host.suites.messages.clear_persistent {
        // SAFETY: the host vouches for its function.
        unsafe { clear(handle) };
    }
}

/// Tells the user something that is not wrong.
pub(crate) fn inform(host: &Host, handle: Handle, text: &str) {
    say(host, handle, MESSAGE, text);
}

/// Writes to the host's log.
pub(crate) fn log(host: &Host, handle: Handle, text: &str) {
    say(host, handle, LOG, text);
}

fn say(host: &Host, handle: Handle, kind: &CStr, text: &str) {
    if let Some(message) = host.suites.messages.message {
        let text = printable(text);
        // SAFETY: as above.
        unsafe {
            message(
                handle,
                kind.as_ptr(),
                ID.as_ptr(),
                TEXT.as_ptr(),
                text.as_ptr(),
            )
        };
    }
}
