//! Lens profiles as handles: opened, asked, released.

use std::ffi::c_char;
use std::fs::File;
use std::io::Read;

use seidel_core::psf;

use crate::guard::guard;
use crate::handles;
use crate::pointers::{Place, Sized64, copy_text, put_sized, text, values};
use crate::status::{Failure, Result, SeidelStatus};
use crate::threads::end_if_unused;

/// The lens is described by moments of its PSFs.
pub const SEIDEL_LENS_MOMENTS: u32 = 0;
/// The lens is known ray by ray: its controls can be set.
pub const SEIDEL_LENS_RAYS: u32 = 1;

/// Largest lens profile that is read, bytes: thousands of planes fit in a tenth of it.
const MOST_BYTES: u64 = 64 << 20;

/// A lens. Any number of threads may use it at once.
#[derive(Debug)]
pub struct SeidelLens {
    _opaque: [u8; 0],
}

/// The lens behind a handle, as measured.
#[derive(Debug)]
pub(crate) struct Lens(seidel_core::Lens);

/// What is known of a lens. Numbers that are not known are NaN.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelLensInfo {
    /// sizeof(SeidelLensInfo); set it before asking.
    pub size: u64,
    /// SEIDEL_LENS_...
    pub kind: u32,
    /// Colour channels: see seidel_lens_channel.
    pub channels: u32,
    /// PSF models that can draw it: see seidel_lens_model.
    pub models: u32,
    /// Whether its blur depends on distance.
    pub knows_depth: u32,
    /// Columns of its frame.
    pub frame_width: u32,
    /// Rows of its frame.
    pub frame_height: u32,
    /// Where its optical axis meets the frame, pixels right of the frame's left edge.
    pub axis_x: f64,
    /// The same, below its top edge.
    pub axis_y: f64,
    /// Pixel pitch, micrometres.
    pub pixel_pitch_um: f64,
    /// Focal length, millimetres.
    pub focal_length_mm: f64,
    /// F-number at which it was measured.
    pub f_number: f64,
    /// Distance at which it was focused, metres; may be INFINITY.
    pub focus_distance: f64,
    /// Nearest distance at which it was measured, metres.
    pub nearest: f64,
    /// Farthest distance at which it was measured, metres; may be INFINITY.
    pub farthest: f64,
}

// SAFETY: `repr(C)`, begins with its size, and holds numbers alone.
unsafe impl Sized64 for SeidelLensInfo {
    const LEAST: usize = size_of::<Self>();

    fn neutral() -> Self {
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

impl Lens {
    /// A lens of its JSON text, told of as `name`.
    fn parse(json: &[u8], name: &str) -> Result<Self> {
        let refuse = |text: String| Failure::new(SeidelStatus::Lens, format!("{name}: {text}"));
        let text = std::str::from_utf8(json).map_err(|error| {
            refuse(format!(
                "is not UTF-8 text (byte {}); give a lens profile that `seidel fit` wrote",
                error.valid_up_to()
            ))
        })?;
        let lens = seidel_core::Lens::from_json(text).map_err(|e| refuse(e.to_string()))?;
        Ok(Self(lens))
    }

    fn read(path: &str) -> Result<Self> {
        let refuse = |text: String| Failure::new(SeidelStatus::Lens, format!("{path}: {text}"));
        let unreadable = |error: std::io::Error| {
            refuse(format!(
                "could not be read ({error}); check the path and its permissions"
            ))
        };
        let file = File::open(path).map_err(unreadable)?;
        let mut bytes = Vec::new();
        // One byte more than allowed tells a file that fits from one that does not.
        (file.take(MOST_BYTES + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(refuse(format!(
                "is longer than {MOST_BYTES} bytes; check that it is a lens profile"
            )));
        }
        Self::parse(&bytes, path)
    }

    /// The lens as measured.
    pub(crate) fn measured(&self) -> &seidel_core::Lens {
        &self.0
    }

    /// The models that can draw it, what suits it best first.
    fn models(&self) -> Vec<&'static str> {
        let best = self.0.predictor().default_model().id();
        let able = psf::ALL
            .iter()
            .filter(|m| self.0.predictor().check_model(**m).is_ok());
        let others = able.map(|model| model.id()).filter(|id| *id != best);
        std::iter::once(best).chain(others).collect()
    }

    fn info(&self) -> SeidelLensInfo {
        let (profile, lens) = (self.0.profile(), self.0.predictor());
        let camera = &profile.camera;
        let known = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let (nearest, farthest) = profile.measured_range_m().unzip();
        let axis = profile.frame.axis();
        SeidelLensInfo {
            kind: match lens.has_rays() {
                true => SEIDEL_LENS_RAYS,
                false => SEIDEL_LENS_MOMENTS,
            },
            channels: lens.channel_names().len() as u32,
            models: self.models().len() as u32,
            knows_depth: u32::from(lens.depends_on_depth()),
            frame_width: profile.frame.width_px(),
            frame_height: profile.frame.height_px(),
            axis_x: axis.x_px,
            axis_y: axis.y_px,
            pixel_pitch_um: known(profile.pixel_pitch_um),
            focal_length_mm: known(camera.focal_length_mm),
            f_number: known(camera.f_number),
            focus_distance: known(camera.focus_distance.vergence_per_m().map(|v| 1.0 / v)),
            nearest: known(nearest),
            farthest: known(farthest),
            ..SeidelLensInfo::neutral()
        }
    }
}

/// Opens the lens profile in the file at `path`, in UTF-8. Release `*lens` when it is no longer needed.
///
/// # Safety
/// `path` must point to a text with a zero at its end, `lens` to a place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_open(
    path: *const c_char,
    lens: *mut *mut SeidelLens,
) -> SeidelStatus {
    guard(|| {
        // SAFETY: as the caller vouches.
        let place = unsafe { Place::new(lens, "lens")? };
        // SAFETY: as the caller vouches.
        let path = unsafe { text(path, "path")? };
        place.put(handles::hold(Lens::read(path)?));
        Ok(())
    })
}

/// The same of the `length` bytes of a profile's JSON text in memory.
///
/// # Safety
/// `json` must point to `length` bytes, `lens` to a place for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_read(
    json: *const c_char,
    length: usize,
    lens: *mut *mut SeidelLens,
) -> SeidelStatus {
    guard(|| {
        // SAFETY: as the caller vouches.
        let place = unsafe { Place::new(lens, "lens")? };
        if json.is_null() || length as u64 > MOST_BYTES {
            return Err(Failure::argument(
                "json",
                format!("is NULL, or longer than {MOST_BYTES} bytes"),
                "give the text of a lens profile",
            ));
        }
        // SAFETY: the caller vouches for `length` bytes.
        let bytes = unsafe { values(json.cast::<u8>(), length, "json")? };
        place.put(handles::hold(Lens::parse(
            &bytes,
            "lens profile in memory",
        )?));
        Ok(())
    })
}

/// Holds a lens once more: it must be released once more.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_lens_retain(lens: *const SeidelLens) -> SeidelStatus {
    guard(|| handles::retain(lens))
}

/// Lets go of a lens; NULL is let go of too. Calls that use it go on. With the last lens the threads of the library end,
/// after the work that they do.
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

/// Tells what is known of a lens. `info->size` must have been set.
///
/// # Safety
/// `info` must point to as many bytes as its size says, which can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_info(
    lens: *const SeidelLens,
    info: *mut SeidelLensInfo,
) -> SeidelStatus {
    guard(|| {
        let told = handles::lens(lens)?.info();
        // SAFETY: as the caller vouches.
        unsafe { put_sized(info, &told, "info") }
    })
}

/// Copies the name of a channel, such as "R", in UTF-8 with a zero at its end; `*needed`, unless NULL, is told how many
/// bytes it takes. SEIDEL_STATUS_TOO_SMALL if that is more than `capacity`; then it is cut.
///
/// # Safety
/// `buffer` must point to `capacity` bytes, `needed` be NULL or a place for a number.
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
        let names = lens.measured().predictor().channel_names();
        let name = names.get(index as usize);
        let name = name.ok_or_else(|| beyond("channel", index, names.len()))?;
        // SAFETY: as the caller vouches.
        unsafe { hand_out(name, buffer, capacity, needed) }
    })
}

/// The same of the name of a PSF model that can draw the lens; the first is what suits it best.
///
/// # Safety
/// That of seidel_lens_channel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_lens_model(
    lens: *const SeidelLens,
    index: u32,
    buffer: *mut c_char,
    capacity: usize,
    needed: *mut usize,
) -> SeidelStatus {
    guard(|| {
        let models = handles::lens(lens)?.models();
        let name = models.get(index as usize);
        let name = name.ok_or_else(|| beyond("model", index, models.len()))?;
        // SAFETY: as the caller vouches.
        unsafe { hand_out(name, buffer, capacity, needed) }
    })
}

pub(crate) fn beyond(what: &str, index: u32, count: usize) -> Failure {
    Failure::argument(
        &format!("{what} {index}"),
        format!("is not there, the lens has {count}"),
        "count from 0",
    )
}

/// # Safety
/// `buffer` must be NULL or `capacity` bytes, `needed` be NULL or a place for a number.
unsafe fn hand_out(
    name: &str,
    buffer: *mut c_char,
    capacity: usize,
    needed: *mut usize,
) -> Result<()> {
    // SAFETY: as the caller vouches.
    let length = unsafe { copy_text(name.as_bytes(), buffer, capacity) };
    if !needed.is_null() {
        // SAFETY: the caller vouches for the place.
        unsafe { needed.write_unaligned(length) };
    }
    match buffer.is_null() || length > capacity {
        true => Err(Failure::new(
            SeidelStatus::TooSmall,
            format!("buffer: holds {capacity} bytes; give room for {length}"),
        )),
        false => Ok(()),
    }
}
