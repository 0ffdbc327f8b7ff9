//! The parameter suite.

use std::ffi::{c_char, c_int, c_uint};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::param::*;

use super::pointers::{found, name, put, put_if};
use super::variadic::{self, Rest};
use crate::host::effect::{Parameter, ParameterSet, Setting};
use crate::host::properties::{numbers, parameter_descriptor};
use crate::host::{Host, under};

pub(super) fn suite() -> OfxParameterSuiteV1 {
    OfxParameterSuiteV1 {
        paramDefine: Some(define),
        paramGetHandle: Some(get_handle),
        paramSetGetPropertySet: Some(set_get_property_set),
        paramGetPropertySet: Some(get_property_set),
        paramGetValue: variadic::get_value(),
        paramGetValueAtTime: variadic::get_value_at_time(),
        paramGetDerivative: variadic::get_derivative(),
        paramGetIntegral: variadic::get_integral(),
        paramSetValue: variadic::set_value(),
        paramSetValueAtTime: variadic::set_value_at_time(),
        paramGetNumKeys: Some(get_num_keys),
        paramGetKeyTime: Some(get_key_time),
        paramGetKeyIndex: Some(get_key_index),
        paramDeleteKey: Some(delete_key),
        paramDeleteAllKeys: Some(delete_all_keys),
        paramCopy: Some(copy),
        paramEditBegin: Some(edit_begin),
        paramEditEnd: Some(edit_end),
    }
}

unsafe extern "C" fn define(
    set: OfxParamSetHandle,
    kind: *const c_char,
    param: *const c_char,
    properties: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let (host, set) = match found::<ParameterSet>(set as usize, "paramDefine") {
        Ok(found) => found,
        Err(status) => return status,
    };
    if set.instance || under::now().is_none_or(|under| !under.defines()) {
        host.misused("paramDefine was called outside DescribeInContext".to_owned());
        return kOfxStatErrBadHandle;
    }
    // SAFETY: the plugin gives strings.
    let (Some(kind), Some(param)) = (unsafe { (name(kind), name(param)) }) else {
        return kOfxStatErrValue;
    };
    let known = [
        kOfxParamTypeString,
        kOfxParamTypeCustom,
        kOfxParamTypeGroup,
        kOfxParamTypePage,
        kOfxParamTypePushButton,
    ];
    let newer = kind == kOfxParamTypeStrChoice && host.profile.api >= (1, 5);
    if numbers(kind).is_none() && !known.contains(&kind) && !newer {
        // Hosts differ in what they have; that plugins ask is no fault.
        return kOfxStatErrUnsupported;
    }
    let text = param.to_string_lossy().into_owned();
    if set.get(&text).is_some() {
        host.misused(format!("parameter {text} was defined twice"));
        return kOfxStatErrExists;
    }
    let values = parameter_descriptor(&host.profile, kind, param);
    let of_kind = format!("parameter descriptor {}", kind.to_string_lossy());
    let title = format!("parameter {text}");
    let made = host.property_set(&of_kind, &title, values, !host.profile.describes);
    let handle = made.handle();
    set.add(&host, kind, &text, made);
    // SAFETY: room for a handle, or NULL if it is not wanted.
    unsafe { put_if(properties, handle as *mut _) };
    kOfxStatOK
}

unsafe extern "C" fn get_handle(
    set: OfxParamSetHandle,
    param: *const c_char,
    handle: *mut OfxParamHandle,
    properties: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let (_, set) = match found::<ParameterSet>(set as usize, "paramGetHandle") {
        Ok(found) => found,
        Err(status) => return status,
    };
    // SAFETY: the plugin gives a string.
    let Some(param) = (unsafe { name(param) }) else {
        return kOfxStatErrValue;
    };
    match set.get(&param.to_string_lossy()) {
        // SAFETY: room for handles, the second NULL if it is not wanted.
        Some(param) => unsafe {
            put_if(properties, param.properties.handle() as *mut _);
            put(handle, param.handle() as *mut _, "paramGetHandle")
        },
        None => kOfxStatErrUnknown,
    }
}

unsafe extern "C" fn set_get_property_set(
    set: OfxParamSetHandle,
    properties: *mut OfxPropertySetHandle,
) -> OfxStatus {
    match found::<ParameterSet>(set as usize, "paramSetGetPropertySet") {
        // SAFETY: the plugin gives room for a handle.
        Ok((_, set)) => unsafe {
            put(
                properties,
                set.properties.handle() as *mut _,
                "paramSetGetPropertySet",
            )
        },
        Err(status) => status,
    }
}

unsafe extern "C" fn get_property_set(
    param: OfxParamHandle,
    properties: *mut OfxPropertySetHandle,
) -> OfxStatus {
    match found::<Parameter>(param as usize, "paramGetPropertySet") {
        // SAFETY: the plugin gives room for a handle.
        Ok((_, param)) => unsafe {
            put(
                properties,
                param.properties.handle() as *mut _,
                "paramGetPropertySet",
            )
        },
        Err(status) => status,
    }
}

fn reached(handle: usize, call: &str) -> Result<(Arc<Host>, Arc<Parameter>), OfxStatus> {
    let (host, param) = found::<Parameter>(handle, call)?;
    if host.spoils() {
        param.spoil();
    }
    Ok((host, param))
}

/// `paramGetValue` and `paramGetValueAtTime`.
///
/// # Safety
/// What follows the handle must be as the parameter's type says.
pub(super) unsafe fn get(handle: usize, times: &[f64], rest: &Rest) -> OfxStatus {
    let call = if times.is_empty() {
        "paramGetValue"
    } else {
        "paramGetValueAtTime"
    };
    let (host, param) = match reached(handle, call) {
        Ok(found) => found,
        Err(status) => return status,
    };
    if times.is_empty() && under::now().is_some_and(|under| under.renders()) {
        host.misused(format!(
            "paramGetValue of {} was called in a render action: only paramGetValueAtTime may be",
            param.name
        ));
    }
    if let ([time], Some(rendering)) = (times, under::now().and_then(|under| under.rendering))
        && *time != rendering.time
    {
        host.misused(format!(
            "paramGetValueAtTime of {} was called for {time} in a render of {}",
            param.name, rendering.time
        ));
    }
    let mut done = kOfxStatOK;
    match param.value() {
        Setting::None => {
            host.misused(format!("{call} of {}, which has no value", param.name));
            return kOfxStatErrUnsupported;
        }
        Setting::Ints(all) => {
            for (i, value) in all.into_iter().enumerate() {
                // SAFETY: room for as many numbers as the type has.
                done = done.max(unsafe { put(rest.pointer::<c_int>(i), value, call) });
            }
        }
        Setting::Doubles(all) => {
            for (i, value) in all.into_iter().enumerate() {
                // SAFETY: as above.
                done = done.max(unsafe { put(rest.pointer::<f64>(i), value, call) });
            }
        }
        Setting::Text(text) => {
            let lent = param.lend(&text);
            // SAFETY: room for a pointer.
            done = unsafe { put(rest.pointer::<*mut c_char>(0), lent, call) };
        }
    }
    done
}

/// `paramGetDerivative`: nothing is animated here.
///
/// # Safety
/// As for `get`.
pub(super) unsafe fn get_derivative(handle: usize, _times: &[f64], rest: &Rest) -> OfxStatus {
    // SAFETY: by the caller's word.
    unsafe { filled(handle, rest, "paramGetDerivative", |_| 0.0) }
}

/// `paramGetIntegral`.
///
/// # Safety
/// As for `get`.
pub(super) unsafe fn get_integral(handle: usize, times: &[f64], rest: &Rest) -> OfxStatus {
    let length = match times {
        [from, to] => to - from,
        _ => 0.0,
    };
    // SAFETY: by the caller's word.
    unsafe { filled(handle, rest, "paramGetIntegral", |value| value * length) }
}

/// # Safety
/// As for `get`.
unsafe fn filled(handle: usize, rest: &Rest, call: &str, of: impl Fn(f64) -> f64) -> OfxStatus {
    match reached(handle, call) {
        Ok((_, param)) => match param.value() {
            Setting::Doubles(all) => {
                for (i, value) in all.into_iter().enumerate() {
                    // SAFETY: room for as many numbers as the type has.
                    unsafe { put(rest.pointer::<f64>(i), of(value), call) };
                }
                kOfxStatOK
            }
            _ => kOfxStatErrUnsupported,
        },
        Err(status) => status,
    }
}

/// `paramSetValue` and `paramSetValueAtTime`.
///
/// # Safety
/// As for `get`.
pub(super) unsafe fn set(handle: usize, _times: &[f64], rest: &Rest) -> OfxStatus {
    let call = "paramSetValue";
    let (host, param) = match reached(handle, call) {
        Ok(found) => found,
        Err(status) => return status,
    };
    match under::now() {
        Some(under) if under.edits() => {}
        under => {
            let action = under.map_or_else(|| "no action".to_owned(), |under| under.action);
            host.misused(format!("{call} of {} was called in {action}", param.name));
            return kOfxStatFailed;
        }
    }
    let setting = match param.value() {
        Setting::None => return kOfxStatErrUnsupported,
        Setting::Ints(all) => Setting::Ints((0..all.len()).map(|i| rest.int(i)).collect()),
        Setting::Doubles(all) => Setting::Doubles((0..all.len()).map(|i| rest.double(i)).collect()),
        // SAFETY: the plugin gives a string.
        Setting::Text(_) => match unsafe { name(rest.pointer::<c_char>(0)) } {
            Some(text) => Setting::Text(text.to_string_lossy().into_owned()),
            None => return kOfxStatErrValue,
        },
    };
    if let Setting::Doubles(all) = &setting
        && all.iter().any(|v| !v.is_finite())
    {
        host.misused(format!("{call} of {} was given {all:?}", param.name));
    }
    param.set(setting);
    kOfxStatOK
}

unsafe extern "C" fn get_num_keys(param: OfxParamHandle, count: *mut c_uint) -> OfxStatus {
    match reached(param as usize, "paramGetNumKeys") {
        // SAFETY: the plugin gives room for a number.
        Ok(_) => unsafe { put(count, 0, "paramGetNumKeys") },
        Err(status) => status,
    }
}

unsafe extern "C" fn get_key_time(
    param: OfxParamHandle,
    _nth: c_uint,
    _time: *mut f64,
) -> OfxStatus {
    reached(param as usize, "paramGetKeyTime")
        .err()
        .unwrap_or(kOfxStatErrBadIndex)
}

unsafe extern "C" fn get_key_index(
    param: OfxParamHandle,
    _time: f64,
    _direction: c_int,
    _index: *mut c_int,
) -> OfxStatus {
    reached(param as usize, "paramGetKeyIndex")
        .err()
        .unwrap_or(kOfxStatFailed)
}

unsafe extern "C" fn delete_key(param: OfxParamHandle, _time: f64) -> OfxStatus {
    reached(param as usize, "paramDeleteKey")
        .err()
        .unwrap_or(kOfxStatErrBadIndex)
}

unsafe extern "C" fn delete_all_keys(param: OfxParamHandle) -> OfxStatus {
    reached(param as usize, "paramDeleteAllKeys")
        .err()
        .unwrap_or(kOfxStatOK)
}

unsafe extern "C" fn copy(
    _to: OfxParamHandle,
    _from: OfxParamHandle,
    _offset: f64,
    _range: *const OfxRangeD,
) -> OfxStatus {
    // As in some hosts, openfx-misc README-hosts.txt.
    kOfxStatErrUnsupported
}

unsafe extern "C" fn edit_begin(set: OfxParamSetHandle, _label: *const c_char) -> OfxStatus {
    match found::<ParameterSet>(set as usize, "paramEditBegin") {
        Ok((host, _)) => {
            if under::now().is_none_or(|under| !under.edits()) {
                host.misused("paramEditBegin was called where nothing may be set".to_owned());
            }
            host.counts.edits_open.fetch_add(1, Ordering::SeqCst);
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn edit_end(set: OfxParamSetHandle) -> OfxStatus {
    match found::<ParameterSet>(set as usize, "paramEditEnd") {
        Ok((host, _)) => {
            host.counts.edits_open.fetch_sub(1, Ordering::SeqCst);
            kOfxStatOK
        }
        Err(status) => status,
    }
}
