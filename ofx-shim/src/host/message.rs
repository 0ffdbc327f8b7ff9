//! Messages to the user and to the host's log.

use std::ffi::{CStr, CString};

use super::Host;
use crate::sys::Handle;
use crate::sys::message::{ERROR, LOG, MESSAGE, Message, WARNING};

/// The format of all messages, so that a `%` in a file name is never taken for a format.
const FORMAT: &CStr = c"%s";
/// Identifier of messages.
const ID: &CStr = c"seidel";

/// Largest number of bytes of a message.
const MAX_BYTES: usize = 4000;

/// Shows the user of an instance an error, until [`clear_message`] if the host supports that.
pub(crate) fn show_error(host: &Host, handle: Handle, text: &str) {
    let messages = &host.suites.messages;
    send(
        messages.set_persistent.or(messages.message),
        handle,
        ERROR,
        text,
    );
}

/// Shows the user of an instance a warning, until [`clear_message`]. Hosts without persistent messages get it in their log, since
/// a box to be closed for every frame would be worse than none.
pub(crate) fn show_warning(host: &Host, handle: Handle, text: &str) {
    match host.suites.messages.set_persistent {
        Some(_) => send(host.suites.messages.set_persistent, handle, WARNING, text),
        None => log(host, handle, text),
    }
}

/// Removes the message that [`show_error`] or [`show_warning`] showed.
pub(crate) fn clear_message(host: &Host, handle: Handle) {
    // Resolve 14 returns an address that is no function (README-hosts of openfx-misc).
    if host.is_resolve() {
        return;
    }
    if let Some(clear) = host.suites.messages.clear_persistent {
        // SAFETY: a function and a handle of the host.
        unsafe { clear(handle) };
    }
}

/// Shows the user of an instance a message that is no error.
pub(crate) fn show_information(host: &Host, handle: Handle, text: &str) {
    send(host.suites.messages.message, handle, MESSAGE, text);
}

/// Writes to the host's log.
pub(crate) fn log(host: &Host, handle: Handle, text: &str) {
    send(host.suites.messages.message, handle, LOG, text);
}

fn send(message: Message, handle: Handle, kind: &CStr, text: &str) {
    let Some(message) = message else {
        return;
    };
    let text = c_text(text);
    let (kind, id) = (kind.as_ptr(), ID.as_ptr());
    // SAFETY: a function and a handle of the host; the format takes one string.
    unsafe { message(handle, kind, id, FORMAT.as_ptr(), text.as_ptr()) };
}

/// Converts a text to a C string, without NUL characters and at most [`MAX_BYTES`] long.
fn c_text(text: &str) -> CString {
    let whole: String = text.chars().filter(|c| *c != '\0').collect();
    let mut end = whole.len().min(MAX_BYTES);
    while !whole.is_char_boundary(end) {
        end -= 1;
    }
    CString::new(&whole[..end]).unwrap_or_default()
}
