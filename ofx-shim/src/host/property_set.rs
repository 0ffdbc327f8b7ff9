//! Property sets of the host's objects.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::null_mut;

use crate::sys::plugin::STATUS_OK;
use crate::sys::property::OfxPropertySuiteV1;
use crate::sys::{Handle, OfxStatus};

/// The properties of an object of the host. Getters return `None` if a property is missing; setters return whether it
/// was set.
#[derive(Clone, Copy)]
pub(crate) struct PropertySet<'h> {
    suite: &'h OfxPropertySuiteV1,
    handle: Handle,
}

impl<'h> PropertySet<'h> {
    /// The set of a handle; empty for NULL.
    pub(super) fn new(suite: &'h OfxPropertySuiteV1, handle: Handle) -> Self {
        Self { suite, handle }
    }

    pub(crate) fn int(&self, name: &CStr, index: i32) -> Option<i32> {
        let mut value = 0;
        let get = self.suite.get_int?;
        // SAFETY: a function and a handle of the host, and memory for the value; so in all calls of this file.
        let success =
            self.succeeds(|| unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) });
        success.then_some(value)
    }

    pub(crate) fn double(&self, name: &CStr, index: i32) -> Option<f64> {
        let mut value = 0.0;
        let get = self.suite.get_double?;
        // SAFETY: as above.
        let success =
            self.succeeds(|| unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) });
        success.then_some(value)
    }

    /// Returns a pointer that is not NULL.
    pub(crate) fn pointer(&self, name: &CStr) -> Option<*mut c_void> {
        let mut value = null_mut();
        let get = self.suite.get_pointer?;
        // SAFETY: as above.
        let success =
            self.succeeds(|| unsafe { get(self.handle, name.as_ptr(), 0, &raw mut value) });
        (success && !value.is_null()).then_some(value)
    }

    pub(crate) fn string(&self, name: &CStr, index: i32) -> Option<String> {
        let mut value: *mut c_char = null_mut();
        let get = self.suite.get_string?;
        // SAFETY: as above.
        let success =
            self.succeeds(|| unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) });
        if !success || value.is_null() {
            return None;
        }
        // SAFETY: a C string, copied before the next call of the host, until which it is valid.
        let text = unsafe { CStr::from_ptr(value) };
        Some(text.to_string_lossy().into_owned())
    }

    /// Returns whether a string property has this value.
    pub(crate) fn equals(&self, name: &CStr, value: &CStr) -> bool {
        let text = self.string(name, 0);
        text.is_some_and(|text| text.as_bytes() == value.to_bytes())
    }

    /// Returns the first `N` numbers, or `None` if one is missing.
    pub(crate) fn doubles<const N: usize>(&self, name: &CStr) -> Option<[f64; N]> {
        let mut out = [0.0; N];
        for (index, out) in out.iter_mut().enumerate() {
            *out = self.double(name, index as i32)?;
        }
        Some(out)
    }

    /// Returns the first `N` integers, or `None` if one is missing.
    pub(crate) fn ints<const N: usize>(&self, name: &CStr) -> Option<[i32; N]> {
        let mut out = [0; N];
        for (index, out) in out.iter_mut().enumerate() {
            *out = self.int(name, index as i32)?;
        }
        Some(out)
    }

    pub(crate) fn set_int(&self, name: &CStr, index: i32, value: i32) -> bool {
        self.suite.set_int.is_some_and(|set| {
            // SAFETY: as above.
            self.succeeds(|| unsafe { set(self.handle, name.as_ptr(), index, value) })
        })
    }

    pub(crate) fn set_double(&self, name: &CStr, index: i32, value: f64) -> bool {
        self.suite.set_double.is_some_and(|set| {
            // SAFETY: as above.
            self.succeeds(|| unsafe { set(self.handle, name.as_ptr(), index, value) })
        })
    }

    /// Sets several numbers, in one call if the host supports that.
    pub(crate) fn set_doubles(&self, name: &CStr, values: &[f64]) -> bool {
        let is_set = self.suite.set_double_n.is_some_and(|set| {
            let count = values.len() as i32;
            // SAFETY: as above; `count` is the number of values.
            self.succeeds(|| unsafe { set(self.handle, name.as_ptr(), count, values.as_ptr()) })
        });
        is_set
            || (values.iter().enumerate())
                .all(|(index, value)| self.set_double(name, index as i32, *value))
    }

    pub(crate) fn set_string(&self, name: &CStr, index: i32, value: &CStr) -> bool {
        self.suite.set_string.is_some_and(|set| {
            let (name, value) = (name.as_ptr(), value.as_ptr());
            // SAFETY: as above; the host copies the string.
            self.succeeds(|| unsafe { set(self.handle, name, index, value) })
        })
    }

    /// Sets the first string to a text without NUL characters.
    pub(crate) fn set_text(&self, name: &CStr, value: &str) -> bool {
        CString::new(value).is_ok_and(|value| self.set_string(name, 0, &value))
    }

    pub(crate) fn set_pointer(&self, name: &CStr, value: *mut c_void) -> bool {
        self.suite.set_pointer.is_some_and(|set| {
            // SAFETY: as above.
            self.succeeds(|| unsafe { set(self.handle, name.as_ptr(), 0, value) })
        })
    }

    fn succeeds(&self, call: impl FnOnce() -> OfxStatus) -> bool {
        !self.handle.is_null() && call() == STATUS_OK
    }
}
