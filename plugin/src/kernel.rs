//! The PSF of a lens at one point of a plate.

use seidel_core::ObjectDistance;

use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::lens::{SeidelLens, beyond};
use crate::plate::{Ground, SeidelPlate};
use crate::pointers::{Place, Sized64, put_sized, sized};
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, SeidelStatus};
use crate::threads::run;

/// A kernel: where the light of one source pixel lands. Set `size`, `weights` and `capacity`; the rest is written.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelKernel {
    /// sizeof(SeidelKernel).
    pub size: u64,
    /// Gets the weights, row by row; they sum to one. May be NULL to learn how many there are.
    pub weights: *mut f32,
    /// How many weights there is room for.
    pub capacity: u64,
    /// Column of the first weight, from the source pixel.
    pub left: i32,
    /// Row of the first weight, from the source pixel.
    pub top: i32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers and a raw pointer.
unsafe impl Sized64 for SeidelKernel {
    const LEAST: usize = size_of::<Self>();

    fn neutral() -> Self {
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

/// Draws the kernel of a channel of a lens at (`x`, `y`), plate pixels right of and below the corner of the pixel (0, 0),
/// for an object `distance` metres away, or INFINITY; NaN for a lens that does not ask. Of the plate, `format` and
/// `extent` count. SEIDEL_STATUS_TOO_SMALL where there is no room for all weights: `width` and `height` tell how many.
///
/// # Safety
/// All pointers must be NULL or good until the call ends, `kernel->weights` for `kernel->capacity` numbers.
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
        // SAFETY: as the caller vouches.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller vouches.
        let ground = unsafe { Ground::new(plate)? };
        // SAFETY: as the caller vouches.
        let mut result = unsafe { sized(kernel.cast_const(), "kernel")? };
        let at = (
            x - f64::from(ground.extent.left),
            y - f64::from(ground.extent.top),
        );
        if !(at.0.is_finite() && at.1.is_finite()) {
            return Err(Failure::argument(
                "x, y",
                format!("are {x}, {y}"),
                "give finite numbers of plate pixels",
            ));
        }
        let session = settings.session(&lens)?;
        let geometry = ground.geometry(&settings);
        let distance = if distance.is_nan() {
            ObjectDistance::Unknown
        } else {
            ObjectDistance::metres(distance)?
        };
        let count = lens.measured().predictor().channel_names().len();
        if channel as usize >= count {
            return Err(beyond("channel", channel, count));
        }
        let work = move |_: &_| Ok(session.kernel_at(&geometry, channel as usize, at, distance)?);
        let found = run(1, &SeidelCallbacks::neutral(), work)?;
        (result.left, result.top) = (found.left, found.top);
        (result.width, result.height) = (found.width as u32, found.height as u32);
        // SAFETY: as the caller vouches.
        unsafe { put_sized(kernel, &result, "kernel")? };
        if result.weights.is_null() || result.capacity < found.weights.len() as u64 {
            return Err(Failure::new(
                SeidelStatus::TooSmall,
                format!(
                    "kernel.capacity: is {}; give room for {} weights",
                    result.capacity,
                    found.weights.len()
                ),
            ));
        }
        for (k, weight) in found.weights.iter().enumerate() {
            // SAFETY: the caller vouches for `capacity` places, of which there are enough.
            unsafe { Place::new(result.weights.wrapping_add(k), "kernel.weights")? }.put(*weight);
        }
        Ok(())
    })
}
