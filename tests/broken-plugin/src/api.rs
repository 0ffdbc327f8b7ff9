//! Properties, parameters and messages, as far as a box blur needs them. What is missing is nothing.

use std::ffi::{CStr, CString, c_char, c_int, c_void};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::message::*;
use openfx::sys::image_effect_v1::param::*;

use crate::state::Suites;

/// The string there, empty for NULL.
///
/// # Safety
/// `at` must be NULL or point to a string.
pub(crate) unsafe fn text_at(at: *const c_char) -> String {
    if at.is_null() {
        return String::new();
    }
    // SAFETY: by the caller's word.
    unsafe { CStr::from_ptr(at) }.to_string_lossy().into_owned()
}

/// A property set of the host, which may be NULL.
#[derive(Clone, Copy)]
pub(crate) struct Set<'a> {
    pub(crate) suites: &'a Suites,
    pub(crate) handle: OfxPropertySetHandle,
}

impl Set<'_> {
    pub(crate) fn int(&self, name: &CStr, index: c_int) -> Option<c_int> {
        let get = self.suites.property.propGetInt?;
        let mut value = 0;
        // SAFETY: room for one value; the handle is not NULL.
        let done = !self.handle.is_null()
            && unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) } == kOfxStatOK;
        done.then_some(value)
    }

    pub(crate) fn double(&self, name: &CStr, index: c_int) -> Option<f64> {
        let get = self.suites.property.propGetDouble?;
        let mut value = 0.0;
        // SAFETY: as above.
        let done = !self.handle.is_null()
            && unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) } == kOfxStatOK;
        done.then_some(value)
    }

    pub(crate) fn pointer(&self, name: &CStr) -> Option<*mut c_void> {
        let get = self.suites.property.propGetPointer?;
        let mut value = std::ptr::null_mut();
        // SAFETY: as above.
        let done = !self.handle.is_null()
            && unsafe { get(self.handle, name.as_ptr(), 0, &raw mut value) } == kOfxStatOK;
        done.then_some(value)
    }

    /// The host's own string, valid until the next call.
    pub(crate) fn raw_text(&self, name: &CStr) -> Option<*const c_char> {
        let get = self.suites.property.propGetString?;
        let mut value = std::ptr::null_mut();
        // SAFETY: as above.
        let done = !self.handle.is_null()
            && unsafe { get(self.handle, name.as_ptr(), 0, &raw mut value) } == kOfxStatOK;
        (done && !value.is_null()).then_some(value.cast_const())
    }

    pub(crate) fn text(&self, name: &CStr) -> Option<String> {
        // SAFETY: copied before anything else is called.
        self.raw_text(name).map(|at| unsafe { text_at(at) })
    }

    pub(crate) fn ints<const N: usize>(&self, name: &CStr) -> Option<[c_int; N]> {
        let mut all = [0; N];
        for (i, value) in all.iter_mut().enumerate() {
            *value = self.int(name, i as c_int)?;
        }
        Some(all)
    }

    pub(crate) fn doubles<const N: usize>(&self, name: &CStr) -> Option<[f64; N]> {
        let mut all = [0.0; N];
        for (i, value) in all.iter_mut().enumerate() {
            *value = self.double(name, i as c_int)?;
        }
        Some(all)
    }

    pub(crate) fn set_int(&self, name: &CStr, value: c_int) {
        if let (Some(set), false) = (self.suites.property.propSetInt, self.handle.is_null()) {
            // SAFETY: the handle is not NULL.
            unsafe { set(self.handle, name.as_ptr(), 0, value) };
        }
    }

    pub(crate) fn set_doubles(&self, name: &CStr, values: &[f64]) {
        if let (Some(set), false) = (self.suites.property.propSetDouble, self.handle.is_null()) {
            for (i, value) in values.iter().enumerate() {
                // SAFETY: as above.
                unsafe { set(self.handle, name.as_ptr(), i as c_int, *value) };
            }
        }
    }

    pub(crate) fn set_texts(&self, name: &CStr, values: &[&CStr]) {
        if let (Some(set), false) = (self.suites.property.propSetString, self.handle.is_null()) {
            for (i, value) in values.iter().enumerate() {
                // SAFETY: as above; the host copies the string.
                unsafe { set(self.handle, name.as_ptr(), i as c_int, value.as_ptr()) };
            }
        }
    }

    pub(crate) fn set_pointer(&self, name: &CStr, value: *mut c_void) {
        if let (Some(set), false) = (self.suites.property.propSetPointer, self.handle.is_null()) {
            // SAFETY: as above.
            unsafe { set(self.handle, name.as_ptr(), 0, value) };
        }
    }
}

/// An effect of the host: a descriptor or an instance.
#[derive(Clone, Copy)]
pub(crate) struct Effect<'a> {
    pub(crate) suites: &'a Suites,
    pub(crate) handle: OfxImageEffectHandle,
}

impl<'a> Effect<'a> {
    pub(crate) fn set(&self) -> Option<Set<'a>> {
        let get = self.suites.effect.getPropertySet?;
        let mut handle = std::ptr::null_mut();
        // SAFETY: room for a handle; the effect is not NULL.
        let done =
            !self.handle.is_null() && unsafe { get(self.handle, &raw mut handle) } == kOfxStatOK;
        done.then_some(Set {
            suites: self.suites,
            handle,
        })
    }

    pub(crate) fn parameters(&self) -> Option<OfxParamSetHandle> {
        let get = self.suites.effect.getParamSet?;
        let mut handle = std::ptr::null_mut();
        // SAFETY: as above.
        let done =
            !self.handle.is_null() && unsafe { get(self.handle, &raw mut handle) } == kOfxStatOK;
        done.then_some(handle)
    }

    pub(crate) fn clip(&self, name: &CStr) -> Option<(OfxImageClipHandle, Set<'a>)> {
        let get = self.suites.effect.clipGetHandle?;
        let (mut clip, mut set) = (std::ptr::null_mut(), std::ptr::null_mut());
        // SAFETY: room for two handles.
        let done = !self.handle.is_null()
            && unsafe { get(self.handle, name.as_ptr(), &raw mut clip, &raw mut set) }
                == kOfxStatOK;
        done.then_some((
            clip,
            Set {
                suites: self.suites,
                handle: set,
            },
        ))
    }

    fn parameter(&self, name: &CStr) -> Option<OfxParamHandle> {
        let get = self.suites.parameter.paramGetHandle?;
        let mut handle = std::ptr::null_mut();
        // SAFETY: room for a handle, none for the set.
        let done = unsafe {
            get(
                self.parameters()?,
                name.as_ptr(),
                &raw mut handle,
                std::ptr::null_mut(),
            )
        };
        (done == kOfxStatOK).then_some(handle)
    }

    pub(crate) fn double(&self, name: &CStr, time: f64) -> Option<f64> {
        let mut value = 0.0_f64;
        let get = self.suites.parameter.paramGetValueAtTime?;
        // SAFETY: a double parameter gives one double.
        let done = unsafe { get(self.parameter(name)?, time, &raw mut value) };
        (done == kOfxStatOK).then_some(value)
    }

    /// Without a time: not for renders.
    pub(crate) fn double_now(&self, name: &CStr) -> Option<f64> {
        let mut value = 0.0_f64;
        let get = self.suites.parameter.paramGetValue?;
        // SAFETY: as above.
        let done = unsafe { get(self.parameter(name)?, &raw mut value) };
        (done == kOfxStatOK).then_some(value)
    }

    pub(crate) fn boolean(&self, name: &CStr, time: f64) -> Option<bool> {
        let mut value: c_int = 0;
        let get = self.suites.parameter.paramGetValueAtTime?;
        // SAFETY: a boolean parameter gives one int.
        let done = unsafe { get(self.parameter(name)?, time, &raw mut value) };
        (done == kOfxStatOK).then_some(value != 0)
    }

    pub(crate) fn string(&self, name: &CStr, time: f64) -> Option<String> {
        let mut value: *mut c_char = std::ptr::null_mut();
        let get = self.suites.parameter.paramGetValueAtTime?;
        // SAFETY: a string parameter gives one pointer; copied before anything else is called.
        unsafe {
            let done = get(self.parameter(name)?, time, &raw mut value);
            (done == kOfxStatOK).then(|| text_at(value))
        }
    }

    /// Says what is wrong, to stay where the host can do that.
    pub(crate) fn complain(&self, text: &str, as_format: bool) {
        let Ok(text) = CString::new(text.replace('\0', " ")) else {
            return;
        };
        let (effect, kind) = (self.handle.cast::<c_void>(), kOfxMessageError.as_ptr());
        let id = c"box".as_ptr();
        let format = if as_format {
            text.as_ptr()
        } else {
            c"%s".as_ptr()
        };
        let second = self.suites.message2;
        let first = self.suites.message1;
        // SAFETY: strings all, and one for the format's only argument.
        unsafe {
            if let Some(say) = second.and_then(|s| s.setPersistentMessage) {
                say(effect, kind, id, format, text.as_ptr());
            } else if let Some(say) = second.and_then(|s| s.message) {
                say(effect, kind, id, format, text.as_ptr());
            } else if let Some(say) = first.and_then(|s| s.message) {
                say(effect, kind, id, format, text.as_ptr());
            }
        }
    }

    /// Takes back what stays, but for the host where the function points to nowhere.
    pub(crate) fn content(&self, anywhere: bool) {
        let host = Set {
            suites: self.suites,
            handle: self.suites.host,
        };
        let name = host.text(kOfxPropName).unwrap_or_default();
        if name.starts_with("DaVinciResolve") && !anywhere {
            return;
        }
        if let Some(clear) = self.suites.message2.and_then(|s| s.clearPersistentMessage) {
            // SAFETY: the effect is the host's.
            unsafe { clear(self.handle.cast()) };
        }
    }
}
