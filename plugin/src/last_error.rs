//! The last error of each thread.

use std::cell::RefCell;
use std::ffi::c_char;

use crate::panics::guard_or;
use crate::pointers::copy_string;

/// Longest text that is stored, bytes; longer texts are cut.
const MAX_BYTES: usize = 2048;

/// Text of a fixed size, without a destructor: no code of this library needs to run when a thread ends.
struct Text {
    bytes: [u8; MAX_BYTES],
    length: usize,
}

thread_local! {
    static LAST: RefCell<Text> = const { RefCell::new(Text { bytes: [0; MAX_BYTES], length: 0 }) };
}

/// Stores `text` as the last error of this thread; an empty text stands for none.
pub(crate) fn set(text: &str) {
    let text = without_controls(text);
    let text = text.as_str();
    let mut ends = (0..=text.len().min(MAX_BYTES)).rev();
    let length = ends.find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    // Access fails only while the thread ends, when nobody can read the error any more.
    let _ = LAST.try_with(|last| {
        let mut last = last.borrow_mut();
        last.bytes[..length].copy_from_slice(&text.as_bytes()[..length]);
        last.length = length;
    });
}

/// Returns the text with its control characters as the escapes of JSON: hosts show it in terminals and logs.
fn without_controls(text: &str) -> String {
    let is_control = |c: char| c.is_control() && c != '\n';
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if is_control(c) {
            out += &format!("\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    out
}

/// Copies a description of the last failure on the calling thread to `buffer`, in UTF-8 with a terminating zero, cut
/// between characters to `capacity` bytes. It names the argument, file or pixel, the problem and the remedy. Returns
/// the size of the whole text in bytes with its zero, at most 2049; 1, an empty text, if the last call succeeded.
/// `buffer` may be NULL to get the size.
///
/// # Safety
/// `buffer`: NULL, or `capacity` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_last_error(buffer: *mut c_char, capacity: usize) -> usize {
    guard_or(1, || {
        let copy = |last: &RefCell<Text>| {
            let last = last.borrow();
            // SAFETY: the caller guarantees `capacity` bytes at `buffer`.
            unsafe { copy_string(&last.bytes[..last.length], buffer, capacity) }
        };
        LAST.try_with(copy).unwrap_or(1)
    })
}

#[cfg(test)]
mod tests {
    use super::without_controls;

    #[test]
    fn control_characters_are_escaped() {
        let text = without_controls("a\u{1b}[2J\r\u{7f}\nß");
        assert_eq!(text, "a\\u001b[2J\\u000d\\u007f\nß");
    }
}
