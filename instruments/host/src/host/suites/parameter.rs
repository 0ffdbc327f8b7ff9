//! The parameter suite. No parameter is animated.

use std::ffi::{c_char, c_int, c_uint};
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::param::*;

use super::pointers::{c_str, with_object, write_optional, write_result};
use super::variadic::{self, Arguments};
use crate::host::Host;
use crate::host::action::current_action;
use crate::host::effect::{EffectRole, Parameter, ParameterSet, ParameterValue};
use crate::host::properties::{numeric_type, parameter_descriptor};

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
    with_object::<ParameterSet>(set as usize, "paramDefine", |host, set| {
        if set.role == EffectRole::Instance
            || current_action().is_none_or(|action| !action.allows_definitions())
        {
            host.record_misuse("paramDefine was called outside DescribeInContext");
            return kOfxStatErrBadHandle;
        }
        // SAFETY: the plugin passes strings.
        let (Some(kind), Some(param)) = (unsafe { (c_str(kind), c_str(param)) }) else {
            return kOfxStatErrValue;
        };
        let other_kinds = [
            kOfxParamTypeString,
            kOfxParamTypeCustom,
            kOfxParamTypeGroup,
            kOfxParamTypePage,
            kOfxParamTypePushButton,
        ];
        let is_new_kind = kind == kOfxParamTypeStrChoice && host.profile.api >= (1, 5);
        if numeric_type(kind).is_none() && !other_kinds.contains(&kind) && !is_new_kind {
            // Not misuse: plugins find out this way what a host supports.
            return kOfxStatErrUnsupported;
        }
        let name = param.to_string_lossy().into_owned();
        if set.get(&name).is_some() {
            host.record_misuse(format!("parameter {name} was defined twice"));
            return kOfxStatErrExists;
        }
        let descriptor = host.property_set(
            &format!("parameter descriptor {}", kind.to_string_lossy()),
            &format!("parameter {name}"),
            parameter_descriptor(&host.profile, kind, param),
            host.profile.descriptor_schema(),
        );
        let handle = descriptor.handle();
        set.add(host, kind, &name, descriptor);
        // SAFETY: NULL or memory for a handle.
        unsafe { write_optional(properties, handle as *mut _) };
        kOfxStatOK
    })
}

unsafe extern "C" fn get_handle(
    set: OfxParamSetHandle,
    param: *const c_char,
    handle: *mut OfxParamHandle,
    properties: *mut OfxPropertySetHandle,
) -> OfxStatus {
    with_object::<ParameterSet>(set as usize, "paramGetHandle", |_, set| {
        // SAFETY: the plugin passes a string.
        let Some(param) = (unsafe { c_str(param) }) else {
            return kOfxStatErrValue;
        };
        match set.get(&param.to_string_lossy()) {
            // SAFETY: memory for handles; the second may be NULL.
            Some(param) => unsafe {
                write_optional(properties, param.properties.handle() as *mut _);
                write_result(handle, param.handle() as *mut _, "paramGetHandle")
            },
            None => kOfxStatErrUnknown,
        }
    })
}

unsafe extern "C" fn set_get_property_set(
    set: OfxParamSetHandle,
    properties: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let call = "paramSetGetPropertySet";
    with_object::<ParameterSet>(set as usize, call, |_, set| {
        // SAFETY: the plugin provides memory for a handle.
        unsafe { write_result(properties, set.properties.handle() as *mut _, call) }
    })
}

unsafe extern "C" fn get_property_set(
    param: OfxParamHandle,
    properties: *mut OfxPropertySetHandle,
) -> OfxStatus {
    let call = "paramGetPropertySet";
    with_object::<Parameter>(param as usize, call, |_, param| {
        // SAFETY: the plugin provides memory for a handle.
        unsafe { write_result(properties, param.properties.handle() as *mut _, call) }
    })
}

/// Calls `work` with the parameter of a handle, after overwriting the strings it has lent.
fn with_parameter(
    handle: usize,
    call: &str,
    work: impl FnOnce(&Host, &Parameter) -> OfxStatus,
) -> OfxStatus {
    with_object::<Parameter>(handle, call, |host, param| {
        if host.overwrites_strings() {
            param.overwrite_lent_strings();
        }
        work(host, param)
    })
}

/// Implements `paramGetValue`, without `times`, and `paramGetValueAtTime`, with one.
///
/// # Safety
/// `arguments` must be pointers to the components of the parameter's type.
pub(super) unsafe fn get(handle: usize, times: &[f64], arguments: &Arguments) -> OfxStatus {
    let call = if times.is_empty() {
        "paramGetValue"
    } else {
        "paramGetValueAtTime"
    };
    with_parameter(handle, call, |host, param| {
        let action = current_action();
        if times.is_empty() && action.as_ref().is_some_and(|a| a.is_render_action()) {
            host.record_misuse(format!(
                "paramGetValue of {} was called in a render action; use paramGetValueAtTime",
                param.name
            ));
        }
        if let ([time], Some(render)) = (times, action.and_then(|action| action.render))
            && *time != render.time
        {
            host.record_misuse(format!(
                "paramGetValueAtTime of {} was called for time {time} in a render of time {}",
                param.name, render.time
            ));
        }
        match param.value() {
            ParameterValue::None => {
                host.record_misuse(format!("{call} of {}, which has no value", param.name));
                kOfxStatErrUnsupported
            }
            ParameterValue::Ints(values) => {
                // SAFETY: guaranteed by the caller.
                unsafe { write_all::<c_int>(arguments, &values, call) }
            }
            ParameterValue::Doubles(values) => {
                // SAFETY: guaranteed by the caller.
                unsafe { write_all::<f64>(arguments, &values, call) }
            }
            ParameterValue::Text(text) => {
                // SAFETY: guaranteed by the caller.
                unsafe { write_all::<*mut c_char>(arguments, &[param.lend(&text)], call) }
            }
        }
    })
}

/// Writes `values` to the pointers in `arguments`. Returns the worst status.
///
/// # Safety
/// `arguments` must be NULL or point to memory for a `T` each.
unsafe fn write_all<T: Copy>(arguments: &Arguments, values: &[T], call: &str) -> OfxStatus {
    let mut status = kOfxStatOK;
    for (i, value) in values.iter().enumerate() {
        // SAFETY: guaranteed by the caller.
        status = status.max(unsafe { write_result(arguments.pointer::<T>(i), *value, call) });
    }
    status
}

/// Implements `paramGetDerivative`.
///
/// # Safety
/// `arguments` must be pointers to the components of the parameter's type.
pub(super) unsafe fn get_derivative(
    handle: usize,
    _times: &[f64],
    arguments: &Arguments,
) -> OfxStatus {
    // SAFETY: guaranteed by the caller.
    unsafe { get_doubles(handle, arguments, "paramGetDerivative", |_| 0.0) }
}

/// Implements `paramGetIntegral`, between two `times`.
///
/// # Safety
/// `arguments` must be pointers to the components of the parameter's type.
pub(super) unsafe fn get_integral(
    handle: usize,
    times: &[f64],
    arguments: &Arguments,
) -> OfxStatus {
    let duration = match times {
        [from, to] => to - from,
        _ => 0.0,
    };
    // SAFETY: guaranteed by the caller.
    unsafe {
        get_doubles(handle, arguments, "paramGetIntegral", |value| {
            value * duration
        })
    }
}

/// Writes a function of a double parameter's components.
///
/// # Safety
/// `arguments` must be pointers to the components of the parameter's type.
unsafe fn get_doubles(
    handle: usize,
    arguments: &Arguments,
    call: &str,
    function: impl Fn(f64) -> f64,
) -> OfxStatus {
    with_parameter(handle, call, |_, param| {
        let ParameterValue::Doubles(values) = param.value() else {
            return kOfxStatErrUnsupported;
        };
        let values: Vec<f64> = values.into_iter().map(function).collect();
        // SAFETY: guaranteed by the caller.
        unsafe { write_all(arguments, &values, call) };
        kOfxStatOK
    })
}

/// Implements `paramSetValue` and `paramSetValueAtTime`.
///
/// # Safety
/// `arguments` must be the components of the parameter's type.
pub(super) unsafe fn set(handle: usize, _times: &[f64], arguments: &Arguments) -> OfxStatus {
    let call = "paramSetValue";
    with_parameter(handle, call, |host, param| {
        let action = current_action();
        if !action.as_ref().is_some_and(|action| action.allows_edits()) {
            let action = action.map_or_else(|| "no action".to_owned(), |action| action.name);
            host.record_misuse(format!("{call} of {} was called in {action}", param.name));
            return kOfxStatFailed;
        }
        let of_overlay = action.is_some_and(|action| action.name.starts_with("OfxInteractAction"));
        if of_overlay && host.counters.edits_open.load(Ordering::SeqCst) == 0 {
            host.counters.undo_steps.fetch_add(1, Ordering::SeqCst);
        }
        let value = match param.value() {
            ParameterValue::None => return kOfxStatErrUnsupported,
            ParameterValue::Ints(old) => {
                ParameterValue::Ints((0..old.len()).map(|i| arguments.int(i)).collect())
            }
            ParameterValue::Doubles(old) => {
                ParameterValue::Doubles((0..old.len()).map(|i| arguments.double(i)).collect())
            }
            // SAFETY: the plugin passes a string.
            ParameterValue::Text(_) => match unsafe { c_str(arguments.pointer::<c_char>(0)) } {
                Some(text) => ParameterValue::Text(text.to_string_lossy().into_owned()),
                None => return kOfxStatErrValue,
            },
        };
        if let ParameterValue::Doubles(values) = &value
            && values.iter().any(|v| !v.is_finite())
        {
            host.record_misuse(format!("{call} of {} was given {values:?}", param.name));
        }
        param.set(value);
        kOfxStatOK
    })
}

unsafe extern "C" fn get_num_keys(param: OfxParamHandle, count: *mut c_uint) -> OfxStatus {
    with_parameter(param as usize, "paramGetNumKeys", |_, _| {
        // SAFETY: the plugin provides memory for a number.
        unsafe { write_result(count, 0, "paramGetNumKeys") }
    })
}

unsafe extern "C" fn get_key_time(
    param: OfxParamHandle,
    _nth: c_uint,
    _time: *mut f64,
) -> OfxStatus {
    with_parameter(param as usize, "paramGetKeyTime", |_, _| {
        kOfxStatErrBadIndex
    })
}

unsafe extern "C" fn get_key_index(
    param: OfxParamHandle,
    _time: f64,
    _direction: c_int,
    _index: *mut c_int,
) -> OfxStatus {
    with_parameter(param as usize, "paramGetKeyIndex", |_, _| kOfxStatFailed)
}

unsafe extern "C" fn delete_key(param: OfxParamHandle, _time: f64) -> OfxStatus {
    with_parameter(param as usize, "paramDeleteKey", |_, _| kOfxStatErrBadIndex)
}

unsafe extern "C" fn delete_all_keys(param: OfxParamHandle) -> OfxStatus {
    with_parameter(param as usize, "paramDeleteAllKeys", |_, _| kOfxStatOK)
}

unsafe extern "C" fn copy(
    _to: OfxParamHandle,
    _from: OfxParamHandle,
    _offset: f64,
    _range: *const OfxRangeD,
) -> OfxStatus {
    // Some hosts do not support it: openfx-misc README-hosts.txt.
    kOfxStatErrUnsupported
}

unsafe extern "C" fn edit_begin(set: OfxParamSetHandle, _label: *const c_char) -> OfxStatus {
    with_object::<ParameterSet>(set as usize, "paramEditBegin", |host, _| {
        if current_action().is_none_or(|action| !action.allows_edits()) {
            host.record_misuse("paramEditBegin was called where parameters must not be set");
        }
        host.counters.edits_open.fetch_add(1, Ordering::SeqCst);
        host.counters.undo_steps.fetch_add(1, Ordering::SeqCst);
        kOfxStatOK
    })
}

unsafe extern "C" fn edit_end(set: OfxParamSetHandle) -> OfxStatus {
    with_object::<ParameterSet>(set as usize, "paramEditEnd", |host, _| {
        host.counters.edits_open.fetch_sub(1, Ordering::SeqCst);
        kOfxStatOK
    })
}
