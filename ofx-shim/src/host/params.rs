//! Parameters of an effect.

use std::ffi::{CStr, c_char, c_int};
use std::ptr::null_mut;

use super::{Host, Props};
use crate::sys::Handle;
use crate::sys::plugin::STATUS_OK;

/// The parameters of an effect.
#[derive(Clone, Copy)]
pub(crate) struct Params<'h> {
    host: &'h Host,
    handle: Handle,
}

impl<'h> Params<'h> {
    pub(super) fn of(host: &'h Host, handle: Handle) -> Self {
        Self { host, handle }
    }

    /// Declares one and gives its properties; nothing where the host has no such type.
    pub(crate) fn define(&self, kind: &CStr, name: &CStr) -> Option<Props<'h>> {
        let define = self.host.suites.param.define?;
        let mut props = null_mut();
        // SAFETY: as above.
        let status = unsafe { define(self.handle, kind.as_ptr(), name.as_ptr(), &raw mut props) };
        (status == STATUS_OK).then(|| Props::of(&self.host.suites.property, props))
    }

    fn find(&self, name: &CStr) -> Option<(Handle, Props<'h>)> {
        let get = self.host.suites.param.handle?;
        let (mut param, mut props) = (null_mut(), null_mut());
        if self.handle.is_null() {
            return None;
        }
        // SAFETY: as above.
        let status = unsafe { get(self.handle, name.as_ptr(), &raw mut param, &raw mut props) };
        let found = status == STATUS_OK && !param.is_null();
        found.then(|| (param, Props::of(&self.host.suites.property, props)))
    }

    /// Properties of one of an instance.
    pub(crate) fn props_of(&self, name: &CStr) -> Option<Props<'h>> {
        self.find(name).map(|(_, props)| props)
    }

    pub(crate) fn number(&self, name: &CStr, time: f64) -> Option<f64> {
        let (param, _) = self.find(name)?;
        let get = self.host.suites.param.value_at_time?;
        let mut value = 0.0_f64;
        // SAFETY: a parameter of one number stores one.
        let status = unsafe { get(param, time, &raw mut value) };
        (status == STATUS_OK).then_some(value)
    }

    pub(crate) fn whole(&self, name: &CStr, time: f64) -> Option<i32> {
        let (param, _) = self.find(name)?;
        let get = self.host.suites.param.value_at_time?;
        let mut value: c_int = 0;
        // SAFETY: a parameter of one whole number, a switch and a choice store one.
        let status = unsafe { get(param, time, &raw mut value) };
        (status == STATUS_OK).then_some(value)
    }

    pub(crate) fn pair(&self, name: &CStr, time: f64) -> Option<(f64, f64)> {
        let (param, _) = self.find(name)?;
        let get = self.host.suites.param.value_at_time?;
        let (mut x, mut y) = (0.0_f64, 0.0_f64);
        // SAFETY: a parameter of two numbers stores two.
        let status = unsafe { get(param, time, &raw mut x, &raw mut y) };
        (status == STATUS_OK).then_some((x, y))
    }

    /// A text, copied: the host's own is good until the next call.
    pub(crate) fn text(&self, name: &CStr, time: f64) -> Option<String> {
        let (param, _) = self.find(name)?;
        let get = self.host.suites.param.value_at_time?;
        let mut value: *mut c_char = null_mut();
        // SAFETY: a text stores a pointer.
        let status = unsafe { get(param, time, &raw mut value) };
        if status != STATUS_OK || value.is_null() {
            return None;
        }
        // SAFETY: a text with a zero at its end.
        Some(
            unsafe { CStr::from_ptr(value) }
                .to_string_lossy()
                .into_owned(),
        )
    }

    /// Sets numbers and whole numbers as one step to undo. Not for renders.
    pub(crate) fn set(&self, step: &CStr, changes: &[(&CStr, Value)]) {
        let suite = &self.host.suites.param;
        // A step is begun where it can be ended.
        let edit = suite.edit_begin.zip(suite.edit_end);
        if let Some((begin, _)) = edit {
            // SAFETY: as above.
            unsafe { begin(self.handle, step.as_ptr()) };
        }
        for (name, value) in changes {
            if let (Some((param, _)), Some(set)) = (self.find(name), suite.set_value) {
                // SAFETY: callers give parameters what they hold: one number, two, or a whole one.
                unsafe {
                    match value {
                        Value::Number(value) => set(param, *value),
                        Value::Whole(value) => set(param, *value),
                        Value::Pair(x, y) => set(param, *x, *y),
                    }
                };
            }
        }
        if let Some((_, end)) = edit {
            // SAFETY: as above.
            unsafe { end(self.handle) };
        }
    }
}

/// What a parameter is set to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Value {
    Number(f64),
    Whole(i32),
    Pair(f64, f64),
}
