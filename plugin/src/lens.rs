//! Lens handles: profiles are opened, described and released.

use std::ffi::c_char;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use seidel_core::{Lens, LibraryLens};
use seidel_optics::psf;

use crate::guard::guard;
use crate::handles::{self, SeidelLens};
use crate::pointers::{
    OutputPointer, Versioned, copy_text, read_array, read_string, write_versioned,
};
use crate::status::{Failure, Result, SeidelStatus};
use crate::threads::end_if_unused;

/// The profile describes moments of PSFs. Focus, f-number and sensor shift cannot be set.
pub const SEIDEL_LENS_MOMENTS: u32 = 0;
/// The profile describes the lens ray by ray. Focus, f-number and sensor shift can be set.
pub const SEIDEL_LENS_RAYS: u32 = 1;

/// Largest lens profile that is read, bytes. A profile of thousands of planes is a tenth as long.
const MAX_BYTES: u64 = 64 << 20;

/// Description of a lens as measured. Unknown numbers are NaN.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelLensInfo {
    /// sizeof(SeidelLensInfo); set it before the call.
    pub size: u64,
    /// SEIDEL_LENS_MOMENTS or SEIDEL_LENS_RAYS.
    pub kind: u32,
    /// Number of colour channels; seidel_lens_channel returns their names.
    pub channels: u32,
    /// Number of PSF models that can draw the lens; seidel_lens_model returns their names.
    pub models: u32,
    /// 1 if the blur depends on distance, else 0.
    pub knows_depth: u32,
    /// Width of the frame, pixels.
    pub frame_width: u32,
    /// Height of the frame, pixels.
    pub frame_height: u32,
    /// Optical axis, pixels to the right of the frame's left edge.
    pub axis_x: f64,
    /// Optical axis, pixels below the frame's top edge.
    pub axis_y: f64,
    /// Pixel pitch, micrometres.
    pub pixel_pitch_um: f64,
    /// Focal length, millimetres.
    pub focal_length_mm: f64,
    /// F-number at which the lens was measured.
    pub f_number: f64,
    /// Focus distance at which the lens was measured, metres; may be INFINITY.
    pub focus_distance: f64,
    /// Smallest object distance that was measured, metres.
    pub nearest: f64,
    /// Largest object distance that was measured, metres; may be INFINITY.
    pub farthest: f64,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers only.
unsafe impl Versioned for SeidelLensInfo {
    const MIN_SIZE: usize = size_of::<Self>();

    fn defaults() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            kind: SEIDEL_LENS_MOMENTS,
            channels: 0,
            models: 0,
            knows_depth: 0,
            frame_width: 0,
            frame_height: 0,
            axis_x: f64::NAN,
            axis_y: f64::NAN,
            pixel_pitch_um: f64::NAN,
            focal_length_mm: f64::NAN,
            f_number: f64::NAN,
            focus_distance: f64::NAN,
            nearest: f64::NAN,
            farthest: f64::NAN,
        }
    }
}

/// Reads a lens profile from JSON text. `source` names it in errors.
fn parse_profile(json: &[u8], source: &str) -> Result<Lens> {
    let text = std::str::from_utf8(json).map_err(|error| {
        profile_error(
            source,
            format!(
                "is not UTF-8 text (byte {}); give a lens profile that `seidel fit` wrote",
                error.valid_up_to()
            ),
        )
    })?;
    Lens::from_json(text).map_err(|error| profile_error(source, error))
}

/// Reads a lens profile from a file, or the lens of the library that `path` names where there is no such file.
fn read_profile(path: &str) -> Result<Lens> {
    if !Path::new(path).exists()
        && let Some(found) = LibraryLens::by_reference(path)
    {
        let unknown =
            |e: seidel_core::Error| profile_error(path, format!("{}; {}", e.problem, e.remedy));
        return parse_profile(found.map_err(unknown)?.profile_json.as_bytes(), path);
    }
    let unreadable = |error: std::io::Error| {
        profile_error(
            path,
            format!("could not be read ({error}); check the path and its permissions"),
        )
    };
    let kind = std::fs::metadata(path).map_err(unreadable)?.file_type();
    if !(kind.is_file() || kind.is_dir()) {
        // Opening a pipe would wait for its writer.
        return Err(profile_error(
            path,
            "is a pipe or a device, not a file; save its content in a file and give that",
        ));
    }
    let file = File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    // One byte more than allowed shows that the file is too long.
    (file.take(MAX_BYTES + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(profile_error(
            path,
            format!("is longer than {MAX_BYTES} bytes; check that it is a lens profile"),
        ));
    }
    parse_profile(&bytes, path)
}

fn profile_error(source: &str, problem: impl std::fmt::Display) -> Failure {
    Failure::new(SeidelStatus::Lens, format!("{source}: {problem}"))
}

/// Returns the PSF models that can draw a lens, the default one first.
fn models(lens: &Lens) -> Vec<&'static str> {
    let predictor = lens.predictor();
    let default = predictor.default_model().id();
    let others = (psf::ALL.iter())
        .filter(|model| predictor.check_model(**model).is_ok())
        .map(|model| model.id())
        .filter(|id| *id != default);
    std::iter::once(default).chain(others).collect()
}

fn describe(lens: &Lens) -> SeidelLensInfo {
    let (profile, predictor) = (lens.profile(), lens.predictor());
    let camera = &profile.camera;
    let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let (nearest, farthest) = profile.measured_range_m().unzip();
    let axis = profile.frame.axis();
    SeidelLensInfo {
        kind: if predictor.has_rays() {
            SEIDEL_LENS_RAYS
        } else {
            SEIDEL_LENS_MOMENTS
        },
        channels: predictor.channel_names().len() as u32,
        models: models(lens).len() as u32,
        knows_depth: u32::from(predictor.depends_on_depth()),
        frame_width: profile.frame.width_px(),
        frame_height: profile.frame.height_px(),
        axis_x: axis.x_px,
        axis_y: axis.y_px,
        pixel_pitch_um: or_nan(profile.pixel_pitch_um),
        focal_length_mm: or_nan(camera.focal_length_mm),
        f_number: or_nan(camera.f_number),
        focus_distance: or_nan(camera.focus_distance.vergence_per_m().map(|v| 1.0 / v)),
        nearest: or_nan(nearest),
        farthest: or_nan(farthest),
        ..SeidelLensInfo::defaults()
    }
}

/// Opens the lens profile in the file `path`, a string in UTF-8, and writes its handle to `*lens`. The caller owns
/// the handle and releases it with seidel_lens_release. After a failure `*lens` is unchanged.
///
/// `path` may also name a lens of the library as library:NAME; `seidel lens list` prints the names. A file of that name
/// comes first.
///
/// Errors: SEIDEL_STATUS_LENS for a file that cannot be read or is not a lens profile.
///
/// # Safety
/// `path`: a string with a terminating zero. `lens`: a writable place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_open(
    path: *const c_char,
    lens: *mut *mut SeidelLens,
) -> SeidelStatus {
    guard(|| {
        // SAFETY: as the caller guarantees.
        let handle = unsafe { OutputPointer::new(lens, "lens")? };
        // SAFETY: as the caller guarantees.
        let path = unsafe { read_string(path, "path")? };
        handle.write(handles::insert(read_profile(path)?));
        Ok(())
    })
}

/// Opens a lens profile like seidel_lens_open, from `length` bytes of JSON text in memory. The text need not end with
/// a zero and is not used after the call.
///
/// Errors: SEIDEL_STATUS_LENS for text that is not a lens profile.
///
/// # Safety
/// `json`: `length` readable bytes. `lens`: a writable place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_read(
    json: *const c_char,
    length: usize,
    lens: *mut *mut SeidelLens,
) -> SeidelStatus {
    guard(|| {
        // SAFETY: as the caller guarantees.
        let handle = unsafe { OutputPointer::new(lens, "lens")? };
        if json.is_null() || length as u64 > MAX_BYTES {
            return Err(Failure::argument(
                "json",
                format!("is NULL or longer than {MAX_BYTES} bytes"),
                "give the text of a lens profile",
            ));
        }
        // SAFETY: the caller guarantees `length` bytes.
        let bytes = unsafe { read_array(json.cast::<u8>(), length, "json")? };
        let lens = parse_profile(&bytes, "lens profile in memory")?;
        handle.write(handles::insert(lens));
        Ok(())
    })
}

/// Adds a reference to a handle: it then needs one more seidel_lens_release.
///
/// Errors: SEIDEL_STATUS_ARGUMENT for a released handle. No memory is read through `lens`, so any value is safe.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_lens_retain(lens: *const SeidelLens) -> SeidelStatus {
    guard(|| handles::retain(lens))
}

/// Removes a reference from a handle; NULL is allowed. The last release frees the lens as soon as no call uses it.
/// When no lens is left, the library's threads finish their work and end, and this call waits for them.
///
/// Errors: SEIDEL_STATUS_ARGUMENT for a released handle. No memory is read through `lens`, so any value is safe.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_lens_release(lens: *const SeidelLens) -> SeidelStatus {
    guard(|| {
        if lens.is_null() {
            return Ok(());
        }
        handles::release(lens)?;
        end_if_unused();
        Ok(())
    })
}

/// Writes a description of a lens to `*info`, whose `size` the caller has set.
///
/// # Safety
/// `info`: as many writable bytes as its `size` states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_info(
    lens: *const SeidelLens,
    info: *mut SeidelLensInfo,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        let description = describe(&lens);
        // SAFETY: as the caller guarantees.
        unsafe { write_versioned(info, &description, "info") }
    })
}

/// Copies the name of colour channel `index`, counted from 0, to `buffer`: for example "R", in UTF-8 with a
/// terminating zero. `*needed` gets the size of the whole name in bytes with its zero.
///
/// Errors: SEIDEL_STATUS_ARGUMENT for an index that the lens does not have; SEIDEL_STATUS_TOO_SMALL if `buffer` is
/// NULL or `capacity` is less than `*needed`, in which case the copy is cut.
///
/// # Safety
/// `buffer`: NULL, or `capacity` writable bytes. `needed`: NULL, or a writable place for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_channel(
    lens: *const SeidelLens,
    index: u32,
    buffer: *mut c_char,
    capacity: usize,
    needed: *mut usize,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        let names = lens.predictor().channel_names();
        let name = names.get(index as usize);
        let name = name.ok_or_else(|| index_error("channel", index, names.len()))?;
        // SAFETY: as the caller guarantees.
        unsafe { copy_text(name, buffer, capacity, needed) }
    })
}

/// Copies the name of PSF model `index`, counted from 0, as seidel_lens_channel does. These are the models that can
/// draw the lens; the first is the default, the most faithful one.
///
/// Errors: those of seidel_lens_channel.
///
/// # Safety
/// As for seidel_lens_channel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_model(
    lens: *const SeidelLens,
    index: u32,
    buffer: *mut c_char,
    capacity: usize,
    needed: *mut usize,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        let models = models(&lens);
        let name = models.get(index as usize);
        let name = name.ok_or_else(|| index_error("model", index, models.len()))?;
        // SAFETY: as the caller guarantees.
        unsafe { copy_text(name, buffer, capacity, needed) }
    })
}

/// The error of an `index` that is not below `count`.
pub(crate) fn index_error(item: &str, index: u32, count: usize) -> Failure {
    Failure::argument(
        &format!("{item} {index}"),
        format!("does not exist: the lens has {count}"),
        "count from 0",
    )
}
