//! The property suite.

use std::ffi::{c_char, c_int, c_void};
use std::sync::Arc;

use openfx::sys::generic::core::*;
use openfx::sys::generic::property::OfxPropertySuiteV1;

use super::pointers::{c_str, resolve, write_result};
use crate::host::properties::{PropertySet, PropertyType, Value, type_of};
use crate::host::{AccessMode, Host};

/// The largest index that plugins may set.
const MAX_INDEX: usize = 4096;

pub(super) fn suite() -> OfxPropertySuiteV1 {
    OfxPropertySuiteV1 {
        propSetPointer: Some(set_pointer),
        propSetString: Some(set_string),
        propSetDouble: Some(set_double),
        propSetInt: Some(set_int),
        propSetPointerN: Some(set_pointers),
        propSetStringN: Some(set_strings),
        propSetDoubleN: Some(set_doubles),
        propSetIntN: Some(set_ints),
        propGetPointer: Some(get_pointer),
        propGetString: Some(get_string),
        propGetDouble: Some(get_double),
        propGetInt: Some(get_int),
        propGetPointerN: Some(get_pointers),
        propGetStringN: Some(get_strings),
        propGetDoubleN: Some(get_doubles),
        propGetIntN: Some(get_ints),
        propReset: Some(reset),
        propGetDimension: Some(get_dimension),
    }
}

type SetHandle = OfxPropertySetHandle;
type Name = *const c_char;

/// A property that a plugin accesses.
struct Property {
    host: Arc<Host>,
    set: Arc<PropertySet>,
    name: String,
    call: &'static str,
}

impl Property {
    /// Resolves a property and records the access. Overwrites the strings that the set has lent.
    ///
    /// # Errors
    /// The status for the plugin, if an argument is invalid or the host lacks the property.
    ///
    /// # Safety
    /// `name` must be NULL or a string.
    unsafe fn access(
        set: SetHandle,
        name: Name,
        mode: AccessMode,
        call: &'static str,
    ) -> Result<Self, OfxStatus> {
        let (host, set) = resolve::<PropertySet>(set as usize, call)?;
        // SAFETY: guaranteed by the caller.
        let Some(name) = (unsafe { c_str(name) }) else {
            host.record_misuse(format!("{call} was given a NULL name"));
            return Err(kOfxStatErrValue);
        };
        let name = name.to_string_lossy().into_owned();
        if host.overwrites_strings() {
            set.overwrite_lent_strings();
        }
        if type_of(&name).is_none() && name.starts_with("Ofx") {
            host.record_misuse(format!("{call}: OpenFX has no property {name}"));
        }
        if !host.access(&set, &name, mode) {
            return Err(kOfxStatErrUnknown);
        }
        Ok(Self {
            host,
            set,
            name,
            call,
        })
    }

    /// Checks that the property may hold values of type `used`; otherwise records misuse.
    fn check_type(&self, used: PropertyType) -> Result<(), OfxStatus> {
        let fits = match type_of(&self.name) {
            Some(PropertyType::Parameter) => {
                let values = self.set.all();
                let first = values.get(&self.name).and_then(|values| values.first());
                first.is_none_or(|first| first.property_type() == used)
            }
            Some(defined) => defined == used,
            None => true,
        };
        if fits { Ok(()) } else { Err(self.wrong_type()) }
    }

    fn wrong_type(&self) -> OfxStatus {
        self.host.record_misuse(format!(
            "{}: {} of {} has another type",
            self.call, self.name, self.set.name
        ));
        kOfxStatErrValue
    }
}

/// Sets values, starting at an index.
///
/// # Safety
/// `name` must be NULL or a string.
unsafe fn set_values(
    set: SetHandle,
    name: Name,
    index: c_int,
    values: Vec<Value>,
    call: &'static str,
) -> OfxStatus {
    let try_set = || {
        // SAFETY: guaranteed by the caller.
        let property = unsafe { Property::access(set, name, AccessMode::Set, call) }?;
        for (i, value) in values.into_iter().enumerate() {
            property.check_type(value.property_type())?;
            let index = usize::try_from(index).map_err(|_| kOfxStatErrBadIndex)? + i;
            if index > MAX_INDEX {
                return Err(kOfxStatErrBadIndex);
            }
            if !property.set.set(&property.name, index, value) {
                return Err(kOfxStatErrUnknown);
            }
        }
        Ok(())
    };
    try_set().err().unwrap_or(kOfxStatOK)
}

unsafe extern "C" fn set_pointer(
    set: SetHandle,
    name: Name,
    index: c_int,
    value: *mut c_void,
) -> OfxStatus {
    let values = vec![Value::Pointer(value as usize)];
    // SAFETY: the plugin passes the name as a string.
    unsafe { set_values(set, name, index, values, "propSetPointer") }
}

unsafe extern "C" fn set_string(
    set: SetHandle,
    name: Name,
    index: c_int,
    value: Name,
) -> OfxStatus {
    // SAFETY: the plugin passes strings.
    unsafe {
        let Some(text) = c_str(value) else {
            return kOfxStatErrValue;
        };
        let values = vec![Value::Text(text.to_owned())];
        set_values(set, name, index, values, "propSetString")
    }
}

unsafe extern "C" fn set_double(set: SetHandle, name: Name, index: c_int, value: f64) -> OfxStatus {
    let values = vec![Value::Double(value)];
    // SAFETY: the plugin passes the name as a string.
    unsafe { set_values(set, name, index, values, "propSetDouble") }
}

unsafe extern "C" fn set_int(set: SetHandle, name: Name, index: c_int, value: c_int) -> OfxStatus {
    // SAFETY: the plugin passes the name as a string.
    unsafe { set_values(set, name, index, vec![Value::Int(value)], "propSetInt") }
}

/// Copies `count` values; none for NULL.
///
/// # Safety
/// `from` must be NULL or point to `count` values.
unsafe fn copy_values<T: Copy>(from: *const T, count: c_int) -> Vec<T> {
    let count = usize::try_from(count).unwrap_or(0);
    if from.is_null() {
        return Vec::new();
    }
    (0..count)
        // SAFETY: guaranteed by the caller.
        .map(|i| unsafe { from.add(i).read_unaligned() })
        .collect()
}

macro_rules! list_setters {
    ($($function:ident($type:ty) $call:literal, $convert:expr;)*) => {$(
        unsafe extern "C" fn $function(
            set: SetHandle,
            name: Name,
            count: c_int,
            values: *const $type,
        ) -> OfxStatus {
            // SAFETY: the plugin passes a string and `count` values.
            unsafe {
                let values = copy_values(values, count).into_iter().map($convert).collect();
                set_values(set, name, 0, values, $call)
            }
        }
    )*};
}

list_setters! {
    set_pointers(*mut c_void) "propSetPointerN", |pointer| Value::Pointer(pointer as usize);
    set_strings(Name) "propSetStringN", |text| Value::Text(c_str(text).unwrap_or(c"").to_owned());
    set_doubles(f64) "propSetDoubleN", Value::Double;
    set_ints(c_int) "propSetIntN", Value::Int;
}

/// Returns `count` values from an index on, with the property.
///
/// # Errors
/// The status for the plugin.
///
/// # Safety
/// `name` must be NULL or a string.
unsafe fn get_values(
    set: SetHandle,
    name: Name,
    index: c_int,
    count: c_int,
    used: PropertyType,
    call: &'static str,
) -> Result<(Property, Vec<Value>), OfxStatus> {
    // SAFETY: guaranteed by the caller.
    let property = unsafe { Property::access(set, name, AccessMode::Read, call) }?;
    let mut all = property.set.all();
    let values = all.remove(&property.name).ok_or(kOfxStatErrUnknown)?;
    property.check_type(used)?;
    let first = usize::try_from(index).map_err(|_| kOfxStatErrBadIndex)?;
    let count = usize::try_from(count).map_err(|_| kOfxStatErrBadIndex)?;
    let values = values
        .get(first..first + count)
        .ok_or(kOfxStatErrBadIndex)?;
    if values.iter().any(|value| value.property_type() != used) {
        return Err(property.wrong_type());
    }
    Ok((property, values.to_vec()))
}

macro_rules! getters {
    ($($one:ident $many:ident($type:ty) $kind:ident, $call:literal, $calls:literal, $convert:expr;)*) => {$(
        unsafe extern "C" fn $one(
            set: SetHandle,
            name: Name,
            index: c_int,
            value: *mut $type,
        ) -> OfxStatus {
            // SAFETY: the plugin passes a string and memory for one value.
            unsafe {
                match get_values(set, name, index, 1, PropertyType::$kind, $call) {
                    Ok((property, values)) => {
                        match values.first().and_then(|v| $convert(&property.set, v)) {
                            Some(found) => write_result(value, found, $call),
                            None => kOfxStatErrValue,
                        }
                    }
                    Err(status) => status,
                }
            }
        }

        unsafe extern "C" fn $many(
            set: SetHandle,
            name: Name,
            count: c_int,
            values: *mut $type,
        ) -> OfxStatus {
            // SAFETY: the plugin passes a string and memory for `count` values.
            unsafe {
                match get_values(set, name, 0, count, PropertyType::$kind, $calls) {
                    Ok((property, found)) => {
                        let found = found.iter().filter_map(|v| $convert(&property.set, v));
                        for (i, value) in found.enumerate() {
                            write_result(values.add(i), value, $calls);
                        }
                        kOfxStatOK
                    }
                    Err(status) => status,
                }
            }
        }
    )*};
}

fn pointer(_: &PropertySet, value: &Value) -> Option<*mut c_void> {
    match value {
        Value::Pointer(pointer) => Some(*pointer as *mut c_void),
        _ => None,
    }
}

fn string(set: &PropertySet, value: &Value) -> Option<*mut c_char> {
    match value {
        Value::Text(text) => Some(set.lend(text)),
        _ => None,
    }
}

fn double(_: &PropertySet, value: &Value) -> Option<f64> {
    match value {
        Value::Double(v) => Some(*v),
        _ => None,
    }
}

fn int(_: &PropertySet, value: &Value) -> Option<c_int> {
    match value {
        Value::Int(v) => Some(*v),
        _ => None,
    }
}

getters! {
    get_pointer get_pointers(*mut c_void) Pointer, "propGetPointer", "propGetPointerN", pointer;
    get_string get_strings(*mut c_char) Text, "propGetString", "propGetStringN", string;
    get_double get_doubles(f64) Double, "propGetDouble", "propGetDoubleN", double;
    get_int get_ints(c_int) Int, "propGetInt", "propGetIntN", int;
}

unsafe extern "C" fn reset(set: SetHandle, name: Name) -> OfxStatus {
    // SAFETY: the plugin passes the name as a string.
    match unsafe { Property::access(set, name, AccessMode::Set, "propReset") } {
        Ok(property) if property.set.reset(&property.name) => kOfxStatOK,
        Ok(_) => kOfxStatErrUnknown,
        Err(status) => status,
    }
}

unsafe extern "C" fn get_dimension(set: SetHandle, name: Name, count: *mut c_int) -> OfxStatus {
    let call = "propGetDimension";
    // SAFETY: the plugin passes a string and memory for one value.
    unsafe {
        match Property::access(set, name, AccessMode::Read, call) {
            Ok(property) => match property.set.all().get(&property.name) {
                Some(values) => {
                    let dimension = c_int::try_from(values.len()).unwrap_or(c_int::MAX);
                    write_result(count, dimension, call)
                }
                None => kOfxStatErrUnknown,
            },
            Err(status) => status,
        }
    }
}
