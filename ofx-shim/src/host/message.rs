//! Messages to the user and to the host's log.

use std::ffi::{CStr, CString};

use super::Host;
use crate::sys::Handle;
use crate::sys::message::{ERROR, LOG, MESSAGE, Message, WARNING};

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

/// Shows the user of an instance a warning, until [`clear_message`].
pub(crate) fn show_warning(host: &Host, handle: Handle, text: &str) {
    show_while_it_holds(host, handle, WARNING, text);
}

/// Shows the user of an instance a note, until [`clear_message`].
pub(crate) fn show_note(host: &Host, handle: Handle, text: &str) {
    show_while_it_holds(host, handle, MESSAGE, text);
}

/// Shows a persistent message. Hosts without them get it in their log, since a box to be closed for every frame would be worse
/// than none.
fn show_while_it_holds(host: &Host, handle: Handle, kind: &CStr, text: &str) {
    match host.suites.messages.set_persistent {
        Some(_) => send(host.suites.messages.set_persistent, handle, kind, text),
        None => log(host, handle, text),
    }
}

/// Removes the message that [`show_error`], [`show_warning`] or [`show_note`] showed.
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
    let format = format_of(text);
    let (kind, id) = (kind.as_ptr(), ID.as_ptr());
    // SAFETY: a function and a handle of the host; the format takes no argument.
    unsafe { message(handle, kind, id, format.as_ptr()) };
}

/// Returns a format of `printf` that prints `text`, without NUL characters and at most [`MAX_BYTES`] long. The format takes no
/// argument, because Natron passes arguments on in a way that prints none of them.
fn format_of(text: &str) -> CString {
    let whole: String = text.chars().filter(|c| *c != '\0').collect();
    let mut end = whole.len().min(MAX_BYTES);
    while !whole.is_char_boundary(end) {
        end -= 1;
    }
    // Cutting after doubling could halve a `%%`.
    CString::new(whole[..end].replace('%', "%%")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_have_no_conversions() {
        assert_eq!(format_of("100 %s\0!").as_c_str(), c"100 %%s!");
        let long = format!("{}%n", "\u{e9}".repeat(MAX_BYTES));
        let format = format_of(&long);
        assert!(format.to_str().is_ok() && format.as_bytes().len() <= MAX_BYTES);
        let all = format_of(&"%".repeat(MAX_BYTES + 1));
        assert_eq!(all.as_bytes(), "%%".repeat(MAX_BYTES).as_bytes());
    }
}
