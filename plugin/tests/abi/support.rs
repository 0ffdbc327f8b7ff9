//! What the tests share: the library loaded, lenses made on the spot, pictures as hosts keep them.

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
type Name = unsafe extern "C" fn(Lens, u32, *mut c_char, usize, *mut usize) -> SeidelStatus;

/// The exports, as the loaded library has them.
pub(crate) struct Doors {
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
    pub(crate) channel: Name,
    pub(crate) model: Name,
    pub(crate) apply: Apply,
    pub(crate) remove: Remove,
    pub(crate) relens: Relens,
    pub(crate) region: Region,
    pub(crate) kernel: Kernel,
    pub(crate) memory: unsafe extern "C" fn(
        *const SeidelSettings,
        *const SeidelPlate,
        u32,
        *mut u64,
    ) -> SeidelStatus,
}

/// The shared library of this build: it lies beside the tests.
pub(crate) fn library() -> PathBuf {
    let tests = std::env::current_exe().expect("a program");
    let name = libloading::library_filename("seidel_c");
    tests.with_file_name(name)
}

/// The exports of the library, loaded once and kept.
pub(crate) fn doors() -> &'static Doors {
    static DOORS: OnceLock<Doors> = OnceLock::new();
    DOORS.get_or_init(|| {
        // SAFETY: the library of this project runs nothing when it is loaded.
        let loaded = unsafe { Library::new(library()) }.expect("the library was built");
        let kept: &'static Library = Box::leak(Box::new(loaded));
        macro_rules! door {
            ($name:literal) => {
                // SAFETY: the types are those of the exports.
                *unsafe { kept.get(concat!($name, "\0").as_bytes()) }.expect($name)
            };
        }
        Doors {
            abi_version: door!("seidel_abi_version"),
            version: door!("seidel_version"),
            last_error: door!("seidel_last_error"),
            shutdown: door!("seidel_shutdown"),
            settings_init: door!("seidel_settings_init"),
            open: door!("seidel_lens_open"),
            read: door!("seidel_lens_read"),
            retain: door!("seidel_lens_retain"),
            release: door!("seidel_lens_release"),
            info: door!("seidel_lens_info"),
            channel: door!("seidel_lens_channel"),
            model: door!("seidel_lens_model"),
            apply: door!("seidel_apply"),
            remove: door!("seidel_remove"),
            relens: door!("seidel_relens"),
            region: door!("seidel_region_of_interest"),
            kernel: door!("seidel_kernel"),
            memory: door!("seidel_memory_needed"),
        }
    })
}

/// The words of the last failure on this thread.
pub(crate) fn why() -> String {
    let mut bytes = vec![0_u8; 4096];
    // SAFETY: the buffer is as long as is said.
    let length = unsafe { (doors().last_error)(bytes.as_mut_ptr().cast(), bytes.len()) };
    String::from_utf8(bytes[..length - 1].to_vec()).expect("UTF-8")
}

/// Fails with the library's words unless a call went well.
#[track_caller]
pub(crate) fn well(status: SeidelStatus) {
    assert_eq!(status, SeidelStatus::Ok, "{}", why());
}

/// A call must be refused with `status`, in words that hold `says`.
#[track_caller]
pub(crate) fn refused(got: SeidelStatus, status: SeidelStatus, says: &str) {
    let words = why();
    assert_eq!(got, status, "{words}");
    assert!(words.contains(says), "`{says}` is missing in: {words}");
}

/// A lens of R, G and B known ray by ray on a frame of 300 x 200, focused at infinity at f/2: blur of 1 to `size` px.
pub(crate) fn profile(size: f64) -> LensProfile {
    let constant = VergenceSeries::constant;
    let channel = |(index, name): (usize, &str)| PupilChannel {
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
        wavelength_px: 0.0,
    };
    let names = ["R", "G", "B"].into_iter().enumerate();
    LensProfile {
        frame: Frame::new(300, 200, None).expect("a valid frame"),
        pixel_pitch_um: Some(6.0),
        camera: Camera {
            focal_length_mm: Some(50.0),
            f_number: Some(2.0),
            ..Camera::default()
        },
        description: LensDescription::Pupil(names.map(channel).collect()),
        held_out: None,
        provenance: Provenance::default(),
    }
}

/// A handle that is released at the end.
pub(crate) struct Held(pub(crate) *mut SeidelLens);

// SAFETY: a handle may be used by any thread.
unsafe impl Send for Held {}
// SAFETY: and by several at once.
unsafe impl Sync for Held {}

impl Held {
    /// The lens of [`profile`].
    pub(crate) fn new(size: f64) -> Self {
        let json = profile(size).to_json();
        let mut lens = std::ptr::null_mut();
        // SAFETY: the text is as long as is said.
        well(unsafe { (doors().read)(json.as_ptr().cast(), json.len(), &mut lens) });
        Self(lens)
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        // SAFETY: a handle may be anything.
        unsafe { (doors().release)(self.0) };
    }
}

/// `text` with a zero at its end.
pub(crate) fn c_text(text: &str) -> CString {
    CString::new(text).expect("no zero within")
}

pub(crate) fn c_path(path: &Path) -> CString {
    c_text(path.to_str().expect("UTF-8"))
}

/// Default settings for objects 2 m away, drawn by Gaussians.
pub(crate) fn settings() -> SeidelSettings {
    static MODEL: OnceLock<CString> = OnceLock::new();
    // SAFETY: any bytes are settings; zeros are NULL and 0.
    let mut settings: SeidelSettings = unsafe { std::mem::zeroed() };
    settings.size = size_of::<SeidelSettings>() as u64;
    // SAFETY: the settings are as large as they say.
    well(unsafe { (doors().settings_init)(&mut settings) });
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

/// A packed picture of floats.
#[derive(Clone)]
pub(crate) struct Picture {
    pub(crate) rect: SeidelRect,
    pub(crate) channels: usize,
    pub(crate) samples: Vec<f32>,
}

impl Picture {
    pub(crate) fn black(rect: SeidelRect, channels: usize) -> Self {
        let count = (rect.width * rect.height) as usize * channels;
        Self {
            rect,
            channels,
            samples: vec![0.0; count],
        }
    }

    /// Of a function of plate pixel and channel.
    pub(crate) fn of(
        rect: SeidelRect,
        channels: usize,
        of: impl Fn(i32, i32, usize) -> f32,
    ) -> Self {
        let mut picture = Self::black(rect, channels);
        for (k, sample) in picture.samples.iter_mut().enumerate() {
            let pixel = (k / channels) as i32;
            let (x, y) = (pixel % rect.width, pixel / rect.width);
            *sample = of(rect.left + x, rect.top + y, k % channels);
        }
        picture
    }

    /// Something of everything: a ramp, edges, small lights; alpha last of 2 or 4.
    pub(crate) fn busy(rect: SeidelRect, channels: usize) -> Self {
        Self::of(rect, channels, |x, y, channel| {
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

    pub(crate) fn image(&self) -> SeidelImage {
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

    /// As an output: samples may be written through it.
    pub(crate) fn output(&mut self) -> SeidelImage {
        SeidelImage {
            data: self.samples.as_mut_ptr().cast(),
            ..self.image()
        }
    }

    /// Its part in `rect`.
    pub(crate) fn cut(&self, rect: SeidelRect) -> Self {
        Self::of(rect, self.channels, |x, y, channel| {
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

/// The plate of a whole picture.
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

/// `seidel_apply` of a plate over `window`, into floats.
pub(crate) fn applied(
    lens: &Held,
    settings: &SeidelSettings,
    plate: &SeidelPlate,
    window: SeidelRect,
) -> Picture {
    // SAFETY: every plate here has a source.
    let channels = unsafe { (*plate.source).channels };
    let mut out = Picture::black(window, channels as usize);
    let image = out.output();
    let none = std::ptr::null();
    // SAFETY: all pointers are good.
    well(unsafe { (doors().apply)(lens.0, settings, plate, &image, none, std::ptr::null()) });
    out
}

/// Largest difference of two pictures.
pub(crate) fn farthest(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    apart.fold(0.0, f32::max)
}
