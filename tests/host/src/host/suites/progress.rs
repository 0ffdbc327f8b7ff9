//! The progress suite, both versions.

use std::ffi::{c_char, c_void};
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::progress::*;

use super::pointers::found;
use crate::host::effect::Effect;

pub(super) fn first() -> OfxProgressSuiteV1 {
    OfxProgressSuiteV1 {
        progressStart: Some(start),
        progressUpdate: Some(update),
        progressEnd: Some(end),
    }
}

pub(super) fn second() -> OfxProgressSuiteV2 {
    OfxProgressSuiteV2 {
        progressStart: Some(start_with_id),
        progressUpdate: Some(update),
        progressEnd: Some(end),
    }
}

unsafe extern "C" fn start(effect: *mut c_void, _label: *const c_char) -> OfxStatus {
    match found::<Effect>(effect as usize, "progressStart") {
        Ok((host, _)) => {
            host.counts.progress_open.fetch_add(1, Ordering::SeqCst);
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn start_with_id(
    effect: *mut c_void,
    label: *const c_char,
    _id: *const c_char,
) -> OfxStatus {
    // SAFETY: the label is not read.
    unsafe { start(effect, label) }
}

unsafe extern "C" fn update(effect: *mut c_void, progress: f64) -> OfxStatus {
    match found::<Effect>(effect as usize, "progressUpdate") {
        Ok((host, _)) => {
            if !(0.0..=1.0).contains(&progress) {
                host.misused(format!("progressUpdate was given {progress}"));
            }
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn end(effect: *mut c_void) -> OfxStatus {
    match found::<Effect>(effect as usize, "progressEnd") {
        Ok((host, _)) => {
            host.counts.progress_open.fetch_sub(1, Ordering::SeqCst);
            kOfxStatOK
        }
        Err(status) => status,
    }
}
