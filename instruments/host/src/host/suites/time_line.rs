//! The time-line suite.

use std::ffi::c_void;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::time_line::*;

use super::pointers::{with_object, write_result};
use crate::host::action::current_action;
use crate::host::effect::Effect;

/// The time that `getTime` reports. It is not that of any render, so a plugin that renders at it is found.
const UI_TIME: f64 = 12345.0;

pub(super) fn suite() -> OfxTimeLineSuiteV1 {
    OfxTimeLineSuiteV1 {
        getTime: Some(get_time),
        gotoTime: Some(goto_time),
        getTimeBounds: Some(get_time_bounds),
    }
}

unsafe extern "C" fn get_time(effect: *mut c_void, time: *mut f64) -> OfxStatus {
    with_object::<Effect>(effect as usize, "getTime", |_, _| {
        // SAFETY: the plugin provides memory for a number.
        unsafe { write_result(time, UI_TIME, "getTime") }
    })
}

unsafe extern "C" fn goto_time(effect: *mut c_void, _time: f64) -> OfxStatus {
    with_object::<Effect>(effect as usize, "gotoTime", |host, _| {
        if current_action().is_some_and(|action| action.is_render_action()) {
            host.record_misuse("gotoTime was called in a render action");
        }
        kOfxStatOK
    })
}

unsafe extern "C" fn get_time_bounds(
    effect: *mut c_void,
    first: *mut f64,
    last: *mut f64,
) -> OfxStatus {
    with_object::<Effect>(effect as usize, "getTimeBounds", |_, _| {
        // SAFETY: the plugin provides memory for two numbers.
        unsafe {
            write_result(first, 0.0, "getTimeBounds");
            write_result(last, 100.0, "getTimeBounds")
        }
    })
}
