//! Strings lent to plugins.

use std::ffi::{CStr, CString, c_char};
use std::sync::Mutex;

use crate::host::locked;

/// Strings that an object of the host has lent to the plugin. They are freed with the object.
#[derive(Debug, Default)]
pub(crate) struct LentStrings(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    valid: Vec<CString>,
    overwritten: Vec<Vec<u8>>,
}

impl LentStrings {
    /// Lends a copy of `text`, which stays valid until [`Self::overwrite`].
    pub(crate) fn lend(&self, text: &CStr) -> *mut c_char {
        let mut state = locked(&self.0);
        state.valid.push(text.to_owned());
        // The bytes of a `CString` do not move with it.
        let kept = state.valid.last();
        kept.map_or(std::ptr::null_mut(), |kept| kept.as_ptr().cast_mut())
    }

    /// Overwrites the strings lent so far. They stay terminated, so that a plugin that still reads one gets a wrong
    /// string rather than a crash.
    pub(crate) fn overwrite(&self) {
        let mut state = locked(&self.0);
        for string in std::mem::take(&mut state.valid) {
            let mut bytes = string.into_bytes_with_nul();
            let end = bytes.len() - 1;
            bytes[..end].fill(b'#');
            state.overwritten.push(bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overwritten_strings_stay_terminated() {
        let lent = LentStrings::default();
        let first = lent.lend(c"first");
        lent.overwrite();
        let second = lent.lend(c"second");
        // SAFETY: `lent` keeps both.
        let (first, second) = unsafe { (CStr::from_ptr(first), CStr::from_ptr(second)) };
        assert_eq!(first, c"#####");
        assert_eq!(second, c"second");
    }
}
