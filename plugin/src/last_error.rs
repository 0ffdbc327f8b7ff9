//! The words of the last failure, one text a thread.

use std::cell::RefCell;
use std::ffi::c_char;

use crate::pointers::copy_text;

/// Longest text that is kept, bytes; longer ones are cut.
const MOST_BYTES: usize = 2048;

/// Text without anything to free: nothing of this library need run when a thread ends.
struct Text {
    bytes: [u8; MOST_BYTES],
    length: usize,
}

thread_local! {
    static LAST: RefCell<Text> = const { RefCell::new(Text { bytes: [0; MOST_BYTES], length: 0 }) };
}

/// Keeps `text` as the last failure of this thread; none if it is empty.
pub(crate) fn keep(text: &str) {
    let mut ends = (0..=text.len().min(MOST_BYTES)).rev();
    // Not within a character.
    let length = ends.find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    // A thread that is ending has nobody left to read it.
    let _ = LAST.try_with(|last| {
        let mut last = last.borrow_mut();
        last.bytes[..length].copy_from_slice(&text.as_bytes()[..length]);
        last.length = length;
    });
}

/// Copies why the last call on this thread failed, in UTF-8 with a zero at its end, cut to `capacity` bytes. Returns the
/// bytes that the whole text takes with its zero; 1, an empty text, after a call that went well. `buffer` may be NULL if
/// `capacity` is 0.
///
/// # Safety
/// `buffer` must point to `capacity` bytes that can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_last_error(buffer: *mut c_char, capacity: usize) -> usize {
    crate::guard::guard_or(1, || {
        let copy = |last: &RefCell<Text>| {
            let last = last.borrow();
            // SAFETY: the caller vouches for `capacity` bytes at `buffer`.
            unsafe { copy_text(&last.bytes[..last.length], buffer, capacity) }
        };
        LAST.try_with(copy).unwrap_or(1)
    })
}
