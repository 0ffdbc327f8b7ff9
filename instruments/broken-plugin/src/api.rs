//! The host's properties, parameters, clips and messages, as far as a box blur needs them.
//!
//! Getters return `None`, and setters do nothing, if a handle, suite or function is missing.

use std::ffi::{CStr, CString, c_char, c_int, c_void};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;
use openfx::sys::image_effect_v1::message::*;
use openfx::sys::image_effect_v1::param::*;

use crate::state::Suites;

/// Copies the string at `text`; empty for NULL.
///
/// # Safety
/// `text` must be NULL or point to a string.
pub(crate) unsafe fn string(text: *const c_char) -> String {
    if text.is_null() {
        return String::new();
    }
    // SAFETY: not NULL, so it points to a string.
    unsafe { CStr::from_ptr(text) }
        .to_string_lossy()
        .into_owned()
}

/// A property set of the host, which may be NULL.
#[derive(Clone, Copy)]
pub(crate) struct PropertySet<'a> {
    pub(crate) suites: &'a Suites,
    pub(crate) handle: OfxPropertySetHandle,
}

macro_rules! getter {
    ($(#[$attribute:meta])* $name:ident: $type:ty = $function:ident, $initial:expr) => {
        $(#[$attribute])*
        pub(crate) fn $name(&self, name: &CStr, index: c_int) -> Option<$type> {
            let get = self.suites.property.$function?;
            if self.handle.is_null() {
                return None;
            }
            let mut value = $initial;
            // SAFETY: memory for one value; the handle is not NULL.
            let status = unsafe { get(self.handle, name.as_ptr(), index, &raw mut value) };
            (status == kOfxStatOK).then_some(value)
        }
    };
}

impl PropertySet<'_> {
    getter!(int: c_int = propGetInt, 0);
    getter!(double: f64 = propGetDouble, 0.0);
    getter!(pointer: *mut c_void = propGetPointer, std::ptr::null_mut());
    getter!(
        /// Returns the host's own string, which is valid until the next suite call.
        raw_string: *mut c_char = propGetString, std::ptr::null_mut()
    );

    pub(crate) fn string(&self, name: &CStr) -> Option<String> {
        let text = self.raw_string(name, 0).filter(|text| !text.is_null())?;
        // SAFETY: the host's string is copied before the next suite call.
        Some(unsafe { string(text) })
    }

    /// Returns the first pointer, unless it is NULL.
    pub(crate) fn non_null(&self, name: &CStr) -> Option<*mut c_void> {
        self.pointer(name, 0).filter(|pointer| !pointer.is_null())
    }

    pub(crate) fn ints<const N: usize>(&self, name: &CStr) -> Option<[c_int; N]> {
        let mut values = [0; N];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.int(name, i as c_int)?;
        }
        Some(values)
    }

    pub(crate) fn doubles<const N: usize>(&self, name: &CStr) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.double(name, i as c_int)?;
        }
        Some(values)
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
                // SAFETY: the handle is not NULL.
                unsafe { set(self.handle, name.as_ptr(), i as c_int, *value) };
            }
        }
    }

    pub(crate) fn set_strings(&self, name: &CStr, values: &[&CStr]) {
        if let (Some(set), false) = (self.suites.property.propSetString, self.handle.is_null()) {
            for (i, value) in values.iter().enumerate() {
                // SAFETY: the handle is not NULL; the host copies the string.
                unsafe { set(self.handle, name.as_ptr(), i as c_int, value.as_ptr()) };
            }
        }
    }

    pub(crate) fn set_pointer(&self, name: &CStr, value: *mut c_void) {
        if let (Some(set), false) = (self.suites.property.propSetPointer, self.handle.is_null()) {
            // SAFETY: the handle is not NULL.
            unsafe { set(self.handle, name.as_ptr(), 0, value) };
        }
    }
}

/// A descriptor or an instance of the plugin, which may be NULL.
#[derive(Clone, Copy)]
pub(crate) struct Effect<'a> {
    pub(crate) suites: &'a Suites,
    pub(crate) handle: OfxImageEffectHandle,
}

/// A clip of an instance.
pub(crate) struct Clip<'a> {
    pub(crate) handle: OfxImageClipHandle,
    pub(crate) properties: PropertySet<'a>,
}

/// The form in which a message is passed to the host.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum MessageFormat {
    /// As the format with each `%` doubled, as it should be.
    Escaped,
    /// As the format as it is.
    Format,
    /// As the argument of the format `%s`.
    Argument,
}

impl<'a> Effect<'a> {
    pub(crate) fn properties(&self) -> Option<PropertySet<'a>> {
        let get = self.suites.effect.getPropertySet?;
        if self.handle.is_null() {
            return None;
        }
        let mut handle = std::ptr::null_mut();
        // SAFETY: memory for a handle; the effect is not NULL.
        let status = unsafe { get(self.handle, &raw mut handle) };
        (status == kOfxStatOK).then_some(PropertySet {
            suites: self.suites,
            handle,
        })
    }

    pub(crate) fn parameters(&self) -> Option<OfxParamSetHandle> {
        let get = self.suites.effect.getParamSet?;
        if self.handle.is_null() {
            return None;
        }
        let mut handle = std::ptr::null_mut();
        // SAFETY: memory for a handle; the effect is not NULL.
        let status = unsafe { get(self.handle, &raw mut handle) };
        (status == kOfxStatOK).then_some(handle)
    }

    pub(crate) fn clip(&self, name: &CStr) -> Option<Clip<'a>> {
        let get = self.suites.effect.clipGetHandle?;
        if self.handle.is_null() {
            return None;
        }
        let (mut clip, mut set) = (std::ptr::null_mut(), std::ptr::null_mut());
        // SAFETY: memory for two handles; the effect is not NULL.
        let status = unsafe { get(self.handle, name.as_ptr(), &raw mut clip, &raw mut set) };
        (status == kOfxStatOK).then_some(Clip {
            handle: clip,
            properties: PropertySet {
                suites: self.suites,
                handle: set,
            },
        })
    }

    fn parameter(&self, name: &CStr) -> Option<OfxParamHandle> {
        let get = self.suites.parameter.paramGetHandle?;
        let parameters = self.parameters()?;
        let mut handle = std::ptr::null_mut();
        let no_properties = std::ptr::null_mut();
        // SAFETY: memory for a handle; the property set is optional.
        let status = unsafe { get(parameters, name.as_ptr(), &raw mut handle, no_properties) };
        (status == kOfxStatOK).then_some(handle)
    }

    pub(crate) fn double(&self, name: &CStr, time: f64) -> Option<f64> {
        let get = self.suites.parameter.paramGetValueAtTime?;
        let mut value = 0.0_f64;
        // SAFETY: a double parameter has one double.
        let status = unsafe { get(self.parameter(name)?, time, &raw mut value) };
        (status == kOfxStatOK).then_some(value)
    }

    /// Returns the current value, which must not be used in renders.
    pub(crate) fn current_double(&self, name: &CStr) -> Option<f64> {
        let get = self.suites.parameter.paramGetValue?;
        let mut value = 0.0_f64;
        // SAFETY: a double parameter has one double.
        let status = unsafe { get(self.parameter(name)?, &raw mut value) };
        (status == kOfxStatOK).then_some(value)
    }

    pub(crate) fn boolean(&self, name: &CStr, time: f64) -> Option<bool> {
        let get = self.suites.parameter.paramGetValueAtTime?;
        let mut value: c_int = 0;
        // SAFETY: a boolean parameter has one int.
        let status = unsafe { get(self.parameter(name)?, time, &raw mut value) };
        (status == kOfxStatOK).then_some(value != 0)
    }

    pub(crate) fn string(&self, name: &CStr, time: f64) -> Option<String> {
        let get = self.suites.parameter.paramGetValueAtTime?;
        let mut value: *mut c_char = std::ptr::null_mut();
        // SAFETY: a string parameter has one pointer, which is copied before the next suite call.
        unsafe {
            let status = get(self.parameter(name)?, time, &raw mut value);
            (status == kOfxStatOK).then(|| string(value))
        }
    }

    /// Posts an error message, persistent if the host supports that.
    pub(crate) fn post_error(&self, text: &str, format: MessageFormat) {
        let text = text.replace('\0', " ");
        let text = match format {
            MessageFormat::Escaped => text.replace('%', "%%"),
            MessageFormat::Format | MessageFormat::Argument => text,
        };
        let Ok(text) = CString::new(text) else {
            return;
        };
        let (effect, kind) = (self.handle.cast::<c_void>(), kOfxMessageError.as_ptr());
        let id = c"box".as_ptr();
        let format = match format {
            MessageFormat::Argument => c"%s".as_ptr(),
            MessageFormat::Escaped | MessageFormat::Format => text.as_ptr(),
        };
        let (v1, v2) = (self.suites.message1, self.suites.message2);
        // SAFETY: strings, with one argument, which the format may ignore.
        unsafe {
            if let Some(post) = v2.and_then(|s| s.setPersistentMessage) {
                post(effect, kind, id, format, text.as_ptr());
            } else if let Some(post) = v2.and_then(|s| s.message) {
                post(effect, kind, id, format, text.as_ptr());
            } else if let Some(post) = v1.and_then(|s| s.message) {
                post(effect, kind, id, format, text.as_ptr());
            }
        }
    }

    /// Clears the persistent message, except in Resolve, where the function is an invalid pointer.
    pub(crate) fn clear_message(&self) {
        let host = PropertySet {
            suites: self.suites,
            handle: self.suites.host,
        };
        let name = host.string(kOfxPropName).unwrap_or_default();
        if !name.starts_with("DaVinciResolve") {
            self.clear_message_anywhere();
        }
    }

    /// Clears the persistent message, even in Resolve.
    pub(crate) fn clear_message_anywhere(&self) {
        if let Some(clear) = self.suites.message2.and_then(|s| s.clearPersistentMessage) {
            // SAFETY: the handle is that of the host.
            unsafe { clear(self.handle.cast()) };
        }
    }
}
