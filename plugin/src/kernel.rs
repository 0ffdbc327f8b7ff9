//! The kernel of a lens at one point of a plate.

use seidel_core::{ObjectDistance, Progress};

use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::handles::SeidelLens;
use crate::lens::index_error;
use crate::plate::{PlateLayout, SeidelPlate};
use crate::pointers::{OutputPointer, Versioned, read_versioned, write_versioned};
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, SeidelStatus};
use crate::threads::run;

/// A kernel: the distribution of the light of one source pixel over plate pixels. The caller sets `size`, `weights`
/// and `capacity`; the library writes the other members.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelKernel {
    /// sizeof(SeidelKernel).
    pub size: u64,
    /// Gets `width` * `height` weights, row by row from the top; their sum is one. NULL: only the size is wanted.
    pub weights: *mut f32,
    /// Number of weights that `weights` has room for.
    pub capacity: u64,
    /// First column, relative to the source pixel.
    pub left: i32,
    /// First row, relative to the source pixel.
    pub top: i32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and a raw pointer.
unsafe impl Versioned for SeidelKernel {
    const MIN_SIZE: usize = size_of::<Self>();

    fn defaults() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            weights: std::ptr::null_mut(),
            capacity: 0,
            left: 0,
            top: 0,
            width: 0,
            height: 0,
        }
    }
}

/// Draws the kernel of lens channel `channel`, counted from 0, at the point (`x`, `y`) of a plate, for an object at
/// `distance`. `x` and `y` are in plate pixels; the centre of pixel (0, 0) is (0.5, 0.5). `distance` is in metres and
/// may be INFINITY, or NaN if the blur of the lens does not depend on it. Of the plate, only `format` and `extent`
/// are used. `settings` may be NULL for the defaults.
///
/// Errors: SEIDEL_STATUS_TOO_SMALL if `weights` is NULL or has too little room; the other members of `*kernel` are
/// then written. Otherwise as for seidel_apply.
///
/// # Safety
/// Each pointer: NULL, or valid until the call returns. `kernel->weights`: NULL, or room for `kernel->capacity`
/// numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_kernel(
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    channel: u32,
    x: f64,
    y: f64,
    distance: f64,
    kernel: *mut SeidelKernel,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        // SAFETY: as the caller guarantees.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller guarantees.
        let layout = unsafe { PlateLayout::new(plate)? };
        // SAFETY: as the caller guarantees.
        let mut result = unsafe { read_versioned(kernel.cast_const(), "kernel")? };
        let at = (
            x - f64::from(layout.extent.left),
            y - f64::from(layout.extent.top),
        );
        if !(at.0.is_finite() && at.1.is_finite()) {
            return Err(Failure::argument(
                "x, y",
                format!("are {x}, {y}"),
                "give finite numbers of plate pixels",
            ));
        }
        let session = settings.session(&lens)?;
        let geometry = layout.geometry(&settings);
        let distance = if distance.is_nan() {
            ObjectDistance::Unknown
        } else {
            ObjectDistance::metres(distance)?
        };
        let count = lens.predictor().channel_names().len();
        if channel as usize >= count {
            return Err(index_error("channel", channel, count));
        }
        let work = move |_: &Progress<'_>| {
            Ok(session.kernel_at(&geometry, channel as usize, at, distance)?)
        };
        let drawn = run(1, &SeidelCallbacks::defaults(), work)?;
        (result.left, result.top) = (drawn.left, drawn.top);
        (result.width, result.height) = (drawn.width as u32, drawn.height as u32);
        // SAFETY: as the caller guarantees.
        unsafe { write_versioned(kernel, &result, "kernel")? };
        if result.weights.is_null() || result.capacity < drawn.weights.len() as u64 {
            return Err(Failure::new(
                SeidelStatus::TooSmall,
                format!(
                    "kernel.capacity: is {}; give room for {} weights",
                    result.capacity,
                    drawn.weights.len()
                ),
            ));
        }
        for (k, weight) in drawn.weights.iter().enumerate() {
            let at = result.weights.wrapping_add(k);
            // SAFETY: the caller guarantees room for `capacity` numbers, which are enough.
            unsafe { OutputPointer::new(at, "kernel.weights")? }.write(*weight);
        }
        Ok(())
    })
}
