//! Helpers: the loaded library, a generated lens, images, and the call that most tests make.

mod exports;
mod image;
mod lens;

use std::ffi::CString;
use std::path::Path;
use std::sync::OnceLock;

use seidel_c::*;

pub(crate) use exports::{CopyName, assert_ok, assert_refused, exports, last_error, library};
pub(crate) use image::{TestImage, max_difference};
pub(crate) use lens::{LensHandle, profile};

/// Returns `text` with a terminating zero.
pub(crate) fn c_text(text: &str) -> CString {
    CString::new(text).expect("text without zeros")
}

pub(crate) fn c_path(path: &Path) -> CString {
    c_text(path.to_str().expect("UTF-8"))
}

/// Returns the default settings, for objects at 2 m and the Gaussian model.
pub(crate) fn settings() -> SeidelSettings {
    static MODEL: OnceLock<CString> = OnceLock::new();
    // SAFETY: all bytes zero are valid settings: NULL and 0.
    let mut settings: SeidelSettings = unsafe { std::mem::zeroed() };
    settings.size = size_of::<SeidelSettings>() as u64;
    // SAFETY: the settings have the size that they state.
    assert_ok(unsafe { (exports().settings_init)(&mut settings) });
    settings.distance = 2.0;
    settings.psf_model = MODEL.get_or_init(|| c_text("gaussian")).as_ptr();
    settings
}

pub(crate) fn rect(left: i32, top: i32, width: i32, height: i32) -> SeidelRect {
    SeidelRect {
        left,
        top,
        width,
        height,
    }
}

/// Returns a plate whose format and extent are `extent`.
pub(crate) fn plate(source: &SeidelImage, extent: SeidelRect) -> SeidelPlate {
    SeidelPlate {
        size: size_of::<SeidelPlate>() as u64,
        format: extent,
        extent,
        source,
        depth: std::ptr::null(),
        matte: std::ptr::null(),
        matte_depth: std::ptr::null(),
        alphas: std::ptr::null(),
        mask: std::ptr::null(),
    }
}

/// Calls `seidel_apply` for the `window` of a plate; returns the result.
pub(crate) fn apply(
    lens: &LensHandle,
    settings: &SeidelSettings,
    plate: &SeidelPlate,
    window: SeidelRect,
) -> TestImage {
    // SAFETY: every plate of these tests has a source.
    let channels = unsafe { (*plate.source).channels };
    let mut out = TestImage::black(window, channels as usize);
    let image = out.output();
    let none = std::ptr::null();
    // SAFETY: all pointers are valid.
    assert_ok(unsafe {
        (exports().apply)(lens.0, settings, plate, &image, none, std::ptr::null())
    });
    out
}
