//! A generated lens, as a profile and as a handle.

use seidel_c::SeidelLens;
use seidel_core::profile::{LensDescription, Provenance, PupilChannel};
use seidel_core::{Camera, Frame, LensProfile};
use seidel_optics::lens::VergenceSeries;

use super::exports::{assert_ok, exports};

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
