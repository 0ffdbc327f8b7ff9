//! Properties of any object. What is missing reads as nothing, and setting it does nothing.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::null_mut;

use crate::sys::Handle;
use crate::sys::plugin::STATUS_OK;
use crate::sys::property::OfxPropertySuiteV1;

/// The properties of an object of the host's.
#[derive(Clone, Copy)]
pub(crate) struct Props<'h> {
    suite: &'h OfxPropertySuiteV1,
    handle: Handle,
}

impl<'h> Props<'h> {
    /// Those behind `handle`, which may be NULL: then there are none.
    pub(crate) fn of(suite: &'h OfxPropertySuiteV1, handle: Handle) -> Self {
        Self { suite, handle }
    }

    pub(crate) fn int(&self, name: &CStr, index: i32) -> Option<i32> {
        let mut value = 0;
        let get = self.suite.get_int?;
        // SAFETY: the host vouches for its function; the place is good.
        self.good(|| unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) })?;
        Some(value)
    }

    pub(crate) fn double(&self, name: &CStr, index: i32) -> Option<f64> {
        let mut value = 0.0;
        let get = self.suite.get_double?;
        // SAFETY: as above.
        self.good(|| unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) })?;
        Some(value)
    }

    pub(crate) fn pointer(&self, name: &CStr) -> Option<*mut c_void> {
        let mut value = null_mut();
        let get = self.suite.get_pointer?;
        // SAFETY: as above.
        self.good(|| unsafe { get(self.handle, name.as_ptr(), 0, &raw mut value) })?;
        (!value.is_null()).then_some(value)
    }

    /// A text, copied: the host's own is good until the next call.
    pub(crate) fn string(&self, name: &CStr, index: i32) -> Option<String> {
        let mut value: *mut c_char = null_mut();
        let get = self.suite.get_string?;
        // SAFETY: as above.
        self.good(|| unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) })?;
        if value.is_null() {
            return None;
        }
        // SAFETY: a text with a zero at its end.
        let text = unsafe { CStr::from_ptr(value) };
        Some(text.to_string_lossy().into_owned())
    }

    /// Whether a text is `value`.
    pub(crate) fn is(&self, name: &CStr, value: &CStr) -> bool {
        let text = self.string(name, 0);
        text.is_some_and(|text| text.as_bytes() == value.to_bytes())
    }

    /// `N` numbers, nothing where one is missing.
    pub(crate) fn doubles<const N: usize>(&self, name: &CStr) -> Option<[f64; N]> {
        let mut out = [0.0; N];
        for (index, out) in out.iter_mut().enumerate() {
            *out = self.double(name, index as i32)?;
        }
        Some(out)
    }

    /// The same of whole numbers.
    pub(crate) fn ints<const N: usize>(&self, name: &CStr) -> Option<[i32; N]> {
        let mut out = [0; N];
        for (index, out) in out.iter_mut().enumerate() {
            *out = self.int(name, index as i32)?;
        }
        Some(out)
    }

    pub(crate) fn set_int(&self, name: &CStr, index: i32, value: i32) -> bool {
        let set = self.suite.set_int;
        set.is_some_and(|set| {
            // SAFETY: the host vouches for its function.
            let done = self.good(|| unsafe { set(self.handle, name.as_ptr(), index, value) });
            done.is_some()
        })
    }

    pub(crate) fn set_double(&self, name: &CStr, index: i32, value: f64) -> bool {
        let set = self.suite.set_double;
        set.is_some_and(|set| {
            // SAFETY: as above.
            let done = self.good(|| unsafe { set(self.handle, name.as_ptr(), index, value) });
            done.is_some()
        })
    }

    /// Sets several numbers, at once where the host can.
    pub(crate) fn set_doubles(&self, name: &CStr, values: &[f64]) -> bool {
        let at_once = self.suite.set_double_n.and_then(|set| {
            let count = values.len() as i32;
            // SAFETY: as many values as are said.
            self.good(|| unsafe { set(self.handle, name.as_ptr(), count, values.as_ptr()) })
        });
        at_once.is_some()
            || (values.iter().enumerate())
                .all(|(index, value)| self.set_double(name, index as i32, *value))
    }

    pub(crate) fn set_string(&self, name: &CStr, index: i32, value: &CStr) -> bool {
        let set = self.suite.set_string;
        set.is_some_and(|set| {
            let (name, value) = (name.as_ptr(), value.as_ptr());
            // SAFETY: as above; the host copies the text.
            let done = self.good(|| unsafe { set(self.handle, name, index, value) });
            done.is_some()
        })
    }

    /// Sets a text that is made as it goes; one with a zero within is not set.
    pub(crate) fn set_text(&self, name: &CStr, value: &str) -> bool {
        CString::new(value).is_ok_and(|value| self.set_string(name, 0, &value))
    }

    pub(crate) fn set_pointer(&self, name: &CStr, value: *mut c_void) -> bool {
        let set = self.suite.set_pointer;
        set.is_some_and(|set| {
            // SAFETY: as above.
            let done = self.good(|| unsafe { set(self.handle, name.as_ptr(), 0, value) });
            done.is_some()
        })
    }

    fn good(&self, call: impl FnOnce() -> i32) -> Option<()> {
        (!self.handle.is_null() && call() == STATUS_OK).then_some(())
    }
}
