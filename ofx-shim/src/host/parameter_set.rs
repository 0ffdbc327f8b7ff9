//! Parameter sets of effects.

use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr::null_mut;

use super::{Host, PropertySet};
use crate::sys::Handle;
use crate::sys::plugin::STATUS_OK;

/// The parameters of an effect.
#[derive(Clone, Copy)]
pub(crate) struct ParameterSet<'h> {
    host: &'h Host,
    handle: Handle,
}

impl<'h> ParameterSet<'h> {
    /// The set of a handle; empty for NULL.
    pub(super) fn new(host: &'h Host, handle: Handle) -> Self {
        Self { host, handle }
    }

    /// Defines a parameter and returns its properties, or `None` if the host does not know its type.
    pub(crate) fn define(&self, kind: &CStr, name: &CStr) -> Option<PropertySet<'h>> {
        let define = self.host.suites.param.define?;
        let mut set = null_mut();
        // SAFETY: a function and a handle of the host, and memory for a handle; so in all calls of this file.
        let status = unsafe { define(self.handle, kind.as_ptr(), name.as_ptr(), &raw mut set) };
        (status == STATUS_OK).then(|| self.host.property_set(set))
    }

    fn find(&self, name: &CStr) -> Option<(Handle, PropertySet<'h>)> {
        let get = self.host.suites.param.handle?;
        let (mut parameter, mut set) = (null_mut(), null_mut());
        if self.handle.is_null() {
            return None;
        }
        let name = name.as_ptr();
        // SAFETY: as above.
        let status = unsafe { get(self.handle, name, &raw mut parameter, &raw mut set) };
        let is_found = status == STATUS_OK && !parameter.is_null();
        is_found.then(|| (parameter, self.host.property_set(set)))
    }

    /// Returns the properties of a parameter of an instance.
    pub(crate) fn properties_of(&self, name: &CStr) -> Option<PropertySet<'h>> {
        self.find(name).map(|(_, properties)| properties)
    }

    /// Returns the value of a parameter of type double.
    pub(crate) fn double(&self, name: &CStr, time: f64) -> Option<f64> {
        let (parameter, _) = self.find(name)?;
        let get = self.host.suites.param.value_at_time?;
        let mut value = 0.0_f64;
        // SAFETY: a parameter of this type stores one double.
        let status = unsafe { get(parameter, time, &raw mut value) };
        (status == STATUS_OK).then_some(value)
    }

    /// Returns the value of a parameter of type integer, boolean or choice.
    pub(crate) fn int(&self, name: &CStr, time: f64) -> Option<i32> {
        let (parameter, _) = self.find(name)?;
        let get = self.host.suites.param.value_at_time?;
        let mut value: c_int = 0;
        // SAFETY: parameters of these types store one integer.
        let status = unsafe { get(parameter, time, &raw mut value) };
        (status == STATUS_OK).then_some(value)
    }

    /// Returns the value of a parameter of type 2D double.
    pub(crate) fn double_2d(&self, name: &CStr, time: f64) -> Option<(f64, f64)> {
        let (parameter, _) = self.find(name)?;
        let get = self.host.suites.param.value_at_time?;
        let (mut x, mut y) = (0.0_f64, 0.0_f64);
        // SAFETY: a parameter of this type stores two doubles.
        let status = unsafe { get(parameter, time, &raw mut x, &raw mut y) };
        (status == STATUS_OK).then_some((x, y))
    }

    /// Returns the value of a parameter of type string.
    pub(crate) fn string(&self, name: &CStr, time: f64) -> Option<String> {
        let (parameter, _) = self.find(name)?;
        let get = self.host.suites.param.value_at_time?;
        let mut value: *mut c_char = null_mut();
        // SAFETY: a parameter of this type stores one pointer.
        let status = unsafe { get(parameter, time, &raw mut value) };
        if status != STATUS_OK || value.is_null() {
            return None;
        }
        // SAFETY: a C string, copied before the next call of the host, until which it is valid.
        let text = unsafe { CStr::from_ptr(value) };
        Some(text.to_string_lossy().into_owned())
    }

    /// Sets parameters, in one undo step called `step`. Must not be called in a render.
    pub(crate) fn set(&self, step: &CStr, changes: &[Change]) {
        let suite = &self.host.suites.param;
        // A step that cannot be ended must not begin.
        let edit = suite.edit_begin.zip(suite.edit_end);
        if let Some((begin, _)) = edit {
            // SAFETY: as above.
            unsafe { begin(self.handle, step.as_ptr()) };
        }
        self.follow(changes);
        if let Some((_, end)) = edit {
            // SAFETY: as above.
            unsafe { end(self.handle) };
        }
    }

    /// Sets parameters as a part of the user's change that the host reports, whose undo step they share: a step of their own for
    /// each move of a drag would be many. Must not be called in a render.
    pub(crate) fn follow(&self, changes: &[Change]) {
        let suite = &self.host.suites.param;
        for (name, value) in changes {
            if let (Some((parameter, _)), Some(set)) = (self.find(name), suite.set_value) {
                // SAFETY: callers pass the type of value that the parameter has.
                unsafe {
                    match value {
                        ParameterValue::Double(value) => set(parameter, *value),
                        ParameterValue::Int(value) => set(parameter, *value),
                        ParameterValue::Double2D(x, y) => set(parameter, *x, *y),
                        // The host copies the text.
                        ParameterValue::Text(text) => set(parameter, text.as_ptr()),
                    }
                };
            }
        }
    }
}

/// A parameter, by name, and its new value.
pub(crate) type Change = (&'static CStr, ParameterValue);

/// A value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ParameterValue {
    Double(f64),
    Int(i32),
    Double2D(f64, f64),
    Text(CString),
}
