//! The property suite.

use std::ffi::{c_char, c_int, c_void};

use openfx::sys::generic::core::*;
use openfx::sys::generic::property::OfxPropertySuiteV1;

use super::pointers::{found, name, put, status};
use crate::host::Host;
use crate::host::properties::{PropertySet, Type, Value, type_of};

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

type Set = OfxPropertySetHandle;
type Name = *const c_char;

/// The set and the property's name, if the property is to be seen at all.
///
/// # Safety
/// `property` must be NULL or a string.
unsafe fn reached(
    set: Set,
    property: Name,
    write: bool,
    call: &str,
) -> Result<(std::sync::Arc<Host>, std::sync::Arc<PropertySet>, String), OfxStatus> {
    let (host, set) = found::<PropertySet>(set as usize, call)?;
    // SAFETY: by the caller's word.
    let Some(property) = (unsafe { name(property) }) else {
        host.misused(format!("{call} was given a NULL name"));
        return Err(kOfxStatErrValue);
    };
    let property = property.to_string_lossy().into_owned();
    if host.spoils() {
        set.spoil();
    }
    if type_of(&property).is_none() && property.starts_with("Ofx") {
        host.misused(format!("{call}: OpenFX has no property {property}"));
    }
    if host.accessed(&set, &property, write) {
        Ok((host, set, property))
    } else {
        Err(kOfxStatErrUnknown)
    }
}

fn right_type(host: &Host, set: &PropertySet, property: &str, kind: Type, call: &str) -> bool {
    let right = match type_of(property) {
        Some(Type::OfParameter) => match set.all().get(property).and_then(|v| v.first()) {
            Some(first) => first.kind() == kind,
            None => true,
        },
        Some(known) => known == kind,
        None => true,
    };
    if !right {
        host.misused(format!(
            "{call}: {property} of {} has another type",
            set.name
        ));
    }
    right
}

/// Sets values from an index on.
///
/// # Safety
/// `property` must be NULL or a string.
unsafe fn set_all(
    set: Set,
    property: Name,
    index: c_int,
    values: Vec<Value>,
    call: &str,
) -> OfxStatus {
    let tried = || {
        // SAFETY: by the caller's word.
        let (host, set, property) = unsafe { reached(set, property, true, call) }?;
        for (i, value) in values.into_iter().enumerate() {
            if !right_type(&host, &set, &property, value.kind(), call) {
                return Err(kOfxStatErrValue);
            }
            let index = usize::try_from(index).map_err(|_| kOfxStatErrBadIndex)? + i;
            if index > 4096 {
                return Err(kOfxStatErrBadIndex);
            }
            if !set.set(&property, index, value) {
                return Err(kOfxStatErrUnknown);
            }
        }
        Ok(())
    };
    status(tried())
}

/// Values from an index on.
///
/// # Safety
/// `property` must be NULL or a string.
unsafe fn get_all(
    set: Set,
    property: Name,
    from: c_int,
    count: Option<c_int>,
    kind: Type,
    call: &str,
) -> Result<(std::sync::Arc<PropertySet>, Vec<Value>), OfxStatus> {
    // SAFETY: by the caller's word.
    let (host, set, property) = unsafe { reached(set, property, false, call) }?;
    let mut all = set.all();
    let values = all.remove(&property).ok_or(kOfxStatErrUnknown)?;
    if !right_type(&host, &set, &property, kind, call) {
        return Err(kOfxStatErrValue);
    }
    let from = usize::try_from(from).map_err(|_| kOfxStatErrBadIndex)?;
    let count = usize::try_from(count.unwrap_or(1)).map_err(|_| kOfxStatErrBadIndex)?;
    let wanted = values.get(from..from + count).ok_or(kOfxStatErrBadIndex)?;
    if wanted.iter().any(|value| value.kind() != kind) {
        host.misused(format!(
            "{call}: {property} of {} has another type",
            set.name
        ));
        return Err(kOfxStatErrValue);
    }
    Ok((set, wanted.to_vec()))
}

unsafe extern "C" fn set_pointer(
    set: Set,
    property: Name,
    index: c_int,
    value: *mut c_void,
) -> OfxStatus {
    let values = vec![Value::Pointer(value as usize)];
    // SAFETY: the plugin names the property by a string.
    unsafe { set_all(set, property, index, values, "propSetPointer") }
}

unsafe extern "C" fn set_string(set: Set, property: Name, index: c_int, value: Name) -> OfxStatus {
    // SAFETY: the plugin gives strings.
    unsafe {
        let Some(text) = name(value) else {
            return kOfxStatErrValue;
        };
        let values = vec![Value::Text(text.to_owned())];
        set_all(set, property, index, values, "propSetString")
    }
}

unsafe extern "C" fn set_double(set: Set, property: Name, index: c_int, value: f64) -> OfxStatus {
    // SAFETY: the plugin names the property by a string.
    unsafe {
        set_all(
            set,
            property,
            index,
            vec![Value::Double(value)],
            "propSetDouble",
        )
    }
}

unsafe extern "C" fn set_int(set: Set, property: Name, index: c_int, value: c_int) -> OfxStatus {
    // SAFETY: the plugin names the property by a string.
    unsafe { set_all(set, property, index, vec![Value::Int(value)], "propSetInt") }
}

/// As many values as are said, copied.
///
/// # Safety
/// `from` must point to `count` values, or be NULL with a `count` of 0.
unsafe fn list<T: Copy>(from: *const T, count: c_int) -> Vec<T> {
    let count = usize::try_from(count).unwrap_or(0);
    if from.is_null() {
        return Vec::new();
    }
    // SAFETY: by the caller's word.
    (0..count)
        .map(|i| unsafe { from.add(i).read_unaligned() })
        .collect()
}

unsafe extern "C" fn set_pointers(
    set: Set,
    property: Name,
    count: c_int,
    from: *const *mut c_void,
) -> OfxStatus {
    // SAFETY: the plugin gives as many values as it says.
    unsafe {
        let values = list(from, count)
            .into_iter()
            .map(|p| Value::Pointer(p as usize))
            .collect();
        set_all(set, property, 0, values, "propSetPointerN")
    }
}

unsafe extern "C" fn set_strings(
    set: Set,
    property: Name,
    count: c_int,
    from: *const Name,
) -> OfxStatus {
    // SAFETY: the plugin gives as many strings as it says.
    unsafe {
        let values = list(from, count)
            .into_iter()
            .map(|at| Value::Text(name(at).unwrap_or(c"").to_owned()))
            .collect();
        set_all(set, property, 0, values, "propSetStringN")
    }
}

unsafe extern "C" fn set_doubles(
    set: Set,
    property: Name,
    count: c_int,
    from: *const f64,
) -> OfxStatus {
    // SAFETY: the plugin gives as many values as it says.
    unsafe {
        let values = list(from, count).into_iter().map(Value::Double).collect();
        set_all(set, property, 0, values, "propSetDoubleN")
    }
}

unsafe extern "C" fn set_ints(
    set: Set,
    property: Name,
    count: c_int,
    from: *const c_int,
) -> OfxStatus {
    // SAFETY: the plugin gives as many values as it says.
    unsafe {
        let values = list(from, count).into_iter().map(Value::Int).collect();
        set_all(set, property, 0, values, "propSetIntN")
    }
}

macro_rules! getters {
    ($($one:ident $many:ident $type:ty, $kind:ident, $call:literal, $calls:literal, $convert:expr;)*) => {$(
        unsafe extern "C" fn $one(set: Set, property: Name, index: c_int, value: *mut $type) -> OfxStatus {
            // SAFETY: the plugin gives a string and room for one value.
            unsafe {
                match get_all(set, property, index, None, Type::$kind, $call) {
                    Ok((set, values)) => match values.first().and_then(|v| $convert(&set, v)) {
                        Some(found) => put(value, found, $call),
                        None => kOfxStatErrValue,
                    },
                    Err(status) => status,
                }
            }
        }

        unsafe extern "C" fn $many(set: Set, property: Name, count: c_int, value: *mut $type) -> OfxStatus {
            // SAFETY: the plugin gives a string and room for as many values as it says.
            unsafe {
                match get_all(set, property, 0, Some(count), Type::$kind, $calls) {
                    Ok((set, values)) => {
                        for (i, found) in values.iter().filter_map(|v| $convert(&set, v)).enumerate() {
                            put(value.add(i), found, $calls);
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
        Value::Pointer(at) => Some(*at as *mut c_void),
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
    get_pointer get_pointers *mut c_void, Pointer, "propGetPointer", "propGetPointerN", pointer;
    get_string get_strings *mut c_char, Text, "propGetString", "propGetStringN", string;
    get_double get_doubles f64, Double, "propGetDouble", "propGetDoubleN", double;
    get_int get_ints c_int, Int, "propGetInt", "propGetIntN", int;
}

unsafe extern "C" fn reset(set: Set, property: Name) -> OfxStatus {
    // SAFETY: the plugin names the property by a string.
    match unsafe { reached(set, property, true, "propReset") } {
        Ok((_, set, property)) if set.reset(&property) => kOfxStatOK,
        Ok(_) => kOfxStatErrUnknown,
        Err(status) => status,
    }
}

unsafe extern "C" fn get_dimension(set: Set, property: Name, count: *mut c_int) -> OfxStatus {
    // SAFETY: the plugin gives a string and room for one value.
    unsafe {
        match reached(set, property, false, "propGetDimension") {
            Ok((_, set, property)) => match set.all().get(&property) {
                Some(values) => {
                    let length = c_int::try_from(values.len()).unwrap_or(c_int::MAX);
                    put(count, length, "propGetDimension")
                }
                None => kOfxStatErrUnknown,
            },
            Err(status) => status,
        }
    }
}
