//! Helpers: the loaded library, generated lenses and images.

use std::ffi::{CString, c_char};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use libloading::Library;
use seidel_c::*;
use seidel_core::camera::Camera;
use seidel_core::field::Frame;
use seidel_core::optics::lens::VergenceSeries;
use seidel_core::profile::{LensDescription, LensProfile, Provenance, PupilChannel};

pub(crate) type Lens = *const SeidelLens;
type Apply = unsafe extern "C" fn(
    Lens,
    *const SeidelSettings,
    *const SeidelPlate,
    *const SeidelImage,
    *const SeidelImage,
    *const SeidelCallbacks,
) -> SeidelStatus;
type Remove = unsafe extern "C" fn(
    Lens,
    *const SeidelSettings,
    *const SeidelPlate,
    *const SeidelImage,
    *const SeidelImage,
    *mut SeidelFindings,
    *const SeidelCallbacks,
) -> SeidelStatus;
type Relens = unsafe extern "C" fn(
    Lens,
    Lens,
    *const SeidelSettings,
    *const SeidelPlate,
    *const SeidelImage,
    *const SeidelImage,
    *const SeidelCallbacks,
) -> SeidelStatus;
type Region = unsafe extern "C" fn(
    Lens,
    *const SeidelSettings,
    *const SeidelPlate,
    *const SeidelRect,
    *mut SeidelRect,
) -> SeidelStatus;
type Kernel = unsafe extern "C" fn(
    Lens,
    *const SeidelSettings,
    *const SeidelPlate,
    u32,
    f64,
    f64,
    f64,
    *mut SeidelKernel,
) -> SeidelStatus;
pub(crate) type CopyName =
    unsafe extern "C" fn(Lens, u32, *mut c_char, usize, *mut usize) -> SeidelStatus;

/// The exports of the loaded library.
pub(crate) struct Exports {
    pub(crate) abi_version: unsafe extern "C" fn() -> u32,
    pub(crate) version: unsafe extern "C" fn() -> *const c_char,
    pub(crate) last_error: unsafe extern "C" fn(*mut c_char, usize) -> usize,
    pub(crate) shutdown: unsafe extern "C" fn() -> SeidelStatus,
    pub(crate) settings_init: unsafe extern "C" fn(*mut SeidelSettings) -> SeidelStatus,
    pub(crate) open: unsafe extern "C" fn(*const c_char, *mut *mut SeidelLens) -> SeidelStatus,
    pub(crate) read:
        unsafe extern "C" fn(*const c_char, usize, *mut *mut SeidelLens) -> SeidelStatus,
    pub(crate) retain: unsafe extern "C" fn(Lens) -> SeidelStatus,
    pub(crate) release: unsafe extern "C" fn(Lens) -> SeidelStatus,
    pub(crate) info: unsafe extern "C" fn(Lens, *mut SeidelLensInfo) -> SeidelStatus,
    pub(crate) channel: CopyName,
    pub(crate) model: CopyName,
    pub(crate) apply: Apply,
    pub(crate) remove: Remove,
    pub(crate) relens: Relens,
    pub(crate) match_colours: Apply,
    pub(crate) region_of_interest: Region,
    pub(crate) kernel: Kernel,
    pub(crate) memory: unsafe extern "C" fn(
        *const SeidelSettings,
        *const SeidelPlate,
        u32,
        *mut u64,
    ) -> SeidelStatus,
}

/// Returns the path of the shared library of this build, which lies beside the tests.
pub(crate) fn library() -> PathBuf {
    let tests = std::env::current_exe().expect("the path of the test");
    let name = libloading::library_filename("seidel_c");
    tests.with_file_name(name)
}

/// Returns the exports of the library, which is loaded once and never unloaded.
pub(crate) fn exports() -> &'static Exports {
    static EXPORTS: OnceLock<Exports> = OnceLock::new();
    EXPORTS.get_or_init(|| {
        // SAFETY: the library of this project runs no code when it is loaded.
        let library = unsafe { Library::new(library()) }.expect("the built library");
        let library: &'static Library = Box::leak(Box::new(library));
        macro_rules! export {
            ($name:literal) => {
                // SAFETY: the types are those of the exports.
                *unsafe { library.get(concat!($name, "\0").as_bytes()) }.expect($name)
            };
        }
        Exports {
            abi_version: export!("seidel_abi_version"),
            version: export!("seidel_version"),
            last_error: export!("seidel_last_error"),
            shutdown: export!("seidel_shutdown"),
            settings_init: export!("seidel_settings_init"),
            open: export!("seidel_lens_open"),
            read: export!("seidel_lens_read"),
            retain: export!("seidel_lens_retain"),
            release: export!("seidel_lens_release"),
            info: export!("seidel_lens_info"),
            channel: export!("seidel_lens_channel"),
            model: export!("seidel_lens_model"),
            apply: export!("seidel_apply"),
            remove: export!("seidel_remove"),
            relens: export!("seidel_relens"),
            match_colours: export!("seidel_match_colours"),
            region_of_interest: export!("seidel_region_of_interest"),
            kernel: export!("seidel_kernel"),
            memory: export!("seidel_memory_needed"),
        }
    })
}

/// Returns the last error of this thread.
pub(crate) fn last_error() -> String {
    let mut bytes = vec![0_u8; 4096];
    // SAFETY: the buffer has the length passed.
    let length = unsafe { (exports().last_error)(bytes.as_mut_ptr().cast(), bytes.len()) };
    String::from_utf8(bytes[..length - 1].to_vec()).expect("UTF-8")
}

/// Asserts that a call succeeded.
#[track_caller]
pub(crate) fn assert_ok(status: SeidelStatus) {
    assert_eq!(status, SeidelStatus::Ok, "{}", last_error());
}

/// Asserts that a call returned `status` with an error that contains `text`.
#[track_caller]
pub(crate) fn assert_refused(got: SeidelStatus, status: SeidelStatus, text: &str) {
    let error = last_error();
    assert_eq!(got, status, "{error}");
    assert!(error.contains(text), "`{text}` is missing in: {error}");
}

/// Returns a `pupil` profile of R, G and B with a frame of 300 x 200, focused at infinity at f/2: blur of 1 to `size`
/// px.
pub(crate) fn profile(size: f64) -> LensProfile {
    let constant = VergenceSeries::constant;
    let channel = |index: usize, name: &str| PupilChannel {
        name: name.to_owned(),
        alpha: VergenceSeries::new(vec![size + 0.3 * index as f64, 1.4 * size]),
        beta: constant(0.4),
        gamma: constant(0.8),
        delta: constant(-0.7),
        phi: constant(0.3),
        blur_variance_px2: constant(0.3),
        effects: Vec::new(),
        magnification: constant(0.004 * index as f64),
        distortion: constant(0.0),
        measured_vergence: (0.0, 1.0 / 1.2),
        stop_lever_m: 0.0,
        added: Vec::new(),
        picture: None,
        wavelength_px: 0.0,
    };
    let channels = ["R", "G", "B"].into_iter().enumerate();
    let channels = channels.map(|(index, name)| channel(index, name));
    LensProfile {
        frame: Frame::new(300, 200, None).expect("a valid frame"),
        pixel_pitch_um: Some(6.0),
        camera: Camera {
            focal_length_mm: Some(50.0),
            f_number: Some(2.0),
            ..Camera::default()
        },
        description: LensDescription::Pupil(channels.collect()),
        held_out: None,
        provenance: Provenance::default(),
    }
}

/// A lens handle, released when it is dropped.
pub(crate) struct LensHandle(pub(crate) *mut SeidelLens);

// SAFETY: any thread may use a handle.
unsafe impl Send for LensHandle {}
// SAFETY: several threads may use a handle at the same time.
unsafe impl Sync for LensHandle {}

impl LensHandle {
    /// Opens the lens of [`profile`].
    pub(crate) fn new(size: f64) -> Self {
        let json = profile(size).to_json();
        let mut lens = std::ptr::null_mut();
        // SAFETY: the text has the length passed.
        assert_ok(unsafe { (exports().read)(json.as_ptr().cast(), json.len(), &mut lens) });
        Self(lens)
    }
}

impl Drop for LensHandle {
    fn drop(&mut self) {
        // SAFETY: any value is safe as a handle.
        unsafe { (exports().release)(self.0) };
    }
}

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

/// An image of packed floats.
#[derive(Clone)]
pub(crate) struct TestImage {
    pub(crate) rect: SeidelRect,
    pub(crate) channels: usize,
    pub(crate) samples: Vec<f32>,
}

impl TestImage {
    pub(crate) fn black(rect: SeidelRect, channels: usize) -> Self {
        let count = (rect.width * rect.height) as usize * channels;
        Self {
            rect,
            channels,
            samples: vec![0.0; count],
        }
    }

    /// Creates an image from a function of plate pixel and channel.
    pub(crate) fn from_fn(
        rect: SeidelRect,
        channels: usize,
        sample_at: impl Fn(i32, i32, usize) -> f32,
    ) -> Self {
        let mut image = Self::black(rect, channels);
        for (k, sample) in image.samples.iter_mut().enumerate() {
            let pixel = (k / channels) as i32;
            let (x, y) = (pixel % rect.width, pixel / rect.width);
            *sample = sample_at(rect.left + x, rect.top + y, k % channels);
        }
        image
    }

    /// Creates an image with a ramp, an edge and point lights; the last of 2 or 4 channels is alpha.
    pub(crate) fn pattern(rect: SeidelRect, channels: usize) -> Self {
        Self::from_fn(rect, channels, |x, y, channel| {
            if channels.is_multiple_of(2) && channel + 1 == channels {
                return if x < 20 { 0.5 } else { 1.0 };
            }
            let light = if x % 17 == 3 && y % 13 == 5 {
                40.0
            } else {
                0.0
            };
            let edge = if x > 60 { 0.6 } else { 0.1 };
            let shade = [1.0, 0.8, 0.5, 1.0][channel];
            shade * (light + edge + 0.003 * y as f32)
        })
    }

    pub(crate) fn input(&self) -> SeidelImage {
        SeidelImage {
            size: size_of::<SeidelImage>() as u64,
            data: self.samples.as_ptr().cast_mut().cast(),
            row_bytes: i64::from(self.rect.width) * self.channels as i64 * 4,
            pixel_bytes: 0,
            channels: self.channels as u32,
            sample: SEIDEL_FLOAT,
            reserved: 0,
            rect: self.rect,
        }
    }

    /// Returns the image as an output, through which its samples may be written.
    pub(crate) fn output(&mut self) -> SeidelImage {
        SeidelImage {
            data: self.samples.as_mut_ptr().cast(),
            ..self.input()
        }
    }

    /// Returns the part of the image in `rect`.
    pub(crate) fn cut(&self, rect: SeidelRect) -> Self {
        Self::from_fn(rect, self.channels, |x, y, channel| {
            let (x, y) = (x - self.rect.left, y - self.rect.top);
            let pixel = (y * self.rect.width + x) as usize;
            self.samples[pixel * self.channels + channel]
        })
    }

    pub(crate) fn plane(&self, channel: usize) -> Vec<f32> {
        let pixels = self.samples.chunks_exact(self.channels);
        pixels.map(|pixel| pixel[channel]).collect()
    }

    pub(crate) fn bits(&self) -> Vec<u32> {
        self.samples.iter().map(|v| v.to_bits()).collect()
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

/// Returns the largest difference of two planes.
pub(crate) fn max_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f32::max)
}
