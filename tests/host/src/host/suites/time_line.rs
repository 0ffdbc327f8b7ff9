//! The time-line suite.

use std::ffi::c_void;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::time_line::*;

use super::pointers::{found, put};
use crate::host::effect::Effect;
use crate::host::under;

pub(super) fn suite() -> OfxTimeLineSuiteV1 {
    OfxTimeLineSuiteV1 {
        getTime: Some(get_time),
        gotoTime: Some(goto_time),
        getTimeBounds: Some(get_time_bounds),
    }
}

unsafe extern "C" fn get_time(effect: *mut c_void, time: *mut f64) -> OfxStatus {
    match found::<Effect>(effect as usize, "getTime") {
        // SAFETY: the plugin gives room for a number. It is not the time of any render.
        Ok(_) => unsafe { put(time, 12345.0, "getTime") },
        Err(status) => status,
    }
}

unsafe extern "C" fn goto_time(effect: *mut c_void, _time: f64) -> OfxStatus {
    match found::<Effect>(effect as usize, "gotoTime") {
        Ok((host, _)) => {
            if under::now().is_some_and(|under| under.renders()) {
                host.misused("gotoTime was called in a render".to_owned());
            }
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn get_time_bounds(
    effect: *mut c_void,
    first: *mut f64,
    last: *mut f64,
) -> OfxStatus {
    match found::<Effect>(effect as usize, "getTimeBounds") {
        // SAFETY: the plugin gives room for two numbers.
        Ok(_) => unsafe {
            put(first, 0.0, "getTimeBounds");
            put(last, 100.0, "getTimeBounds")
        },
        Err(status) => status,
    }
}
