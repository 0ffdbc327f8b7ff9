//! Both versions of the progress suite.

use std::ffi::{c_char, c_void};
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::progress::*;

use super::pointers::with_object;
use crate::host::effect::Effect;

pub(super) fn suite_v1() -> OfxProgressSuiteV1 {
    OfxProgressSuiteV1 {
        progressStart: Some(start),
        progressUpdate: Some(update),
        progressEnd: Some(end),
    }
}

pub(super) fn suite_v2() -> OfxProgressSuiteV2 {
    OfxProgressSuiteV2 {
        progressStart: Some(start_with_id),
        progressUpdate: Some(update),
        progressEnd: Some(end),
    }
}

unsafe extern "C" fn start(effect: *mut c_void, _label: *const c_char) -> OfxStatus {
    with_object::<Effect>(effect as usize, "progressStart", |host, _| {
        host.counters.progress_open.fetch_add(1, Ordering::SeqCst);
        kOfxStatOK
    })
}

unsafe extern "C" fn start_with_id(
    effect: *mut c_void,
    label: *const c_char,
    _id: *const c_char,
) -> OfxStatus {
    // SAFETY: `start` does not read the label.
    unsafe { start(effect, label) }
}

unsafe extern "C" fn update(effect: *mut c_void, progress: f64) -> OfxStatus {
    with_object::<Effect>(effect as usize, "progressUpdate", |host, _| {
        if !(0.0..=1.0).contains(&progress) {
            host.record_misuse(format!("progressUpdate was given {progress}"));
        }
        kOfxStatOK
    })
}

unsafe extern "C" fn end(effect: *mut c_void) -> OfxStatus {
    with_object::<Effect>(effect as usize, "progressEnd", |host, _| {
        host.counters.progress_open.fetch_sub(1, Ordering::SeqCst);
        kOfxStatOK
    })
}
