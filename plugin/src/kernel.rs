//! The PSF of a lens at one point of a plate.

use seidel_core::distance::ObjectDistance;
use seidel_core::plate::Vergences;
use seidel_core::render::{LocalKernel, LocalKernels, Scene};

use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::job::Sight;
use crate::lens::{SeidelLens, beyond};
use crate::plate::{Ground, SeidelPlate};
use crate::pointers::{Place, Sized64, put_sized, sized};
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, Result, SeidelStatus};
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
        let mut told = unsafe { sized(kernel.cast_const(), "kernel")? };
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
        let sight = Sight::new(&lens, &settings, |lens| ground.placed(lens, &settings))?;
        let vergence = vergence(&sight, distance)?;
        let count = lens.measured().channel_names().len();
        if channel as usize >= count {
            return Err(beyond("channel", channel, count));
        }
        let work = move |_: &_| drawn(&sight, channel as usize, at, vergence);
        let drawn = run(1, &SeidelCallbacks::neutral(), work)?;
        (told.left, told.top) = (drawn.left, drawn.top);
        (told.width, told.height) = (drawn.width as u32, drawn.height as u32);
        // SAFETY: as the caller vouches.
        unsafe { put_sized(kernel, &told, "kernel")? };
        if told.weights.is_null() || told.capacity < drawn.weights.len() as u64 {
            return Err(Failure::new(
                SeidelStatus::TooSmall,
                format!(
                    "kernel.capacity: is {}; give room for {} weights",
                    told.capacity,
                    drawn.weights.len()
                ),
            ));
        }
        for (k, weight) in drawn.weights.iter().enumerate() {
            // SAFETY: the caller vouches for `capacity` places, of which there are enough.
            unsafe { Place::new(told.weights.wrapping_add(k), "kernel.weights")? }.put(*weight);
        }
        Ok(())
    })
}

fn vergence(sight: &Sight, distance: f64) -> Result<f64> {
    let distance = match distance.is_nan() {
        true => ObjectDistance::Unknown,
        false => ObjectDistance::metres(distance)?,
    };
    Ok(sight.predictor.vergence(distance)?)
}

fn drawn(sight: &Sight, channel: usize, at: (f64, f64), vergence: f64) -> Result<LocalKernel> {
    let lens_use = sight.lens_use();
    lens_use.seen(&sight.placed, Vergences::Constant(vergence), |seen| {
        // The point alone is looked at, not the plate about it.
        let scene = Scene {
            width: 1,
            height: 1,
            ..seen.scene
        };
        let mut weights = vec![0.0; scene.lens.channel_count()];
        weights[channel] = 1.0;
        Ok(LocalKernels::new(&scene, &weights)?.at(at)?)
    })
}
