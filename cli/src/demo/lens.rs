//! The built-in lens: a fast vintage 50 mm prime, wide open.
//!
//! It is given by five reduced numbers per channel (docs/background/model.md section 3), of which defocus alone
//! varies with distance. Its character: tear-shaped highlights in the corners (coma and astigmatism),
//! green rims behind the focus and purple ones in front of it (axial colour), red and blue fringes
//! towards the corners (lateral colour), and a sharp image near the centre of the focused plane only.

use std::collections::BTreeMap;

use seidel_core::profile::{LensDescription, Provenance, PupilChannel};
use seidel_core::{Camera, Frame, LensProfile, ObjectDistance, Result};
use seidel_optics::lens::VergenceSeries;

/// Focal length, mm.
pub const FOCAL_LENGTH_MM: f64 = 50.0;
/// F-number.
pub const F_NUMBER: f64 = 0.95;
/// Focused distance, m.
pub const FOCUS_M: f64 = 2.0;
/// Sensor width, mm; with the focal length it gives the field of view of the scene.
pub const SENSOR_WIDTH_MM: f64 = 36.0;

/// Width of the frame that the pixels below refer to, px; lengths in the field are half frame widths.
pub(super) const DESIGN_WIDTH_PX: f64 = 1280.0;

pub(super) const CHANNELS: [&str; 3] = ["R", "G", "B"];
const WAVELENGTH_NM: [f64; 3] = [620.0, 540.0, 460.0];
/// Defocus on the focused plane by channel (axial colour), px.
const ALPHA_FOCUS_PX: [f64; 3] = [1.0, 0.0, 1.8];
/// Coma by channel, px.
const PHI_PX: [f64; 3] = [-4.9, -4.5, -4.0];
/// Magnification by channel, relative to the mean (lateral colour).
const MAGNIFICATION: [f64; 3] = [0.0028, 0.0, -0.0034];

/// Spherical aberration, px.
const BETA_PX: f64 = 1.6;
/// Astigmatism, px per squared half frame width.
const GAMMA_PX: f64 = -7.0;
/// Field curvature, px per squared half frame width.
const DELTA_PX: f64 = 1.0;
/// Distortion per squared half frame width: slight barrel.
const DISTORTION: f64 = -0.004;

/// Variance of the symmetric blur, px²: diffraction and the sensor's low-pass filter.
const BLUR_VARIANCE_PX2: f64 = 0.1;

/// Range of measured vergences that the profile states, 1/m: infinity to 1.2 m.
const MEASURED_PER_M: (f64, f64) = (0.0, 1.0 / 1.2);

/// Returns the built-in lens for a frame of `width_px` x `height_px` with its axis at the centre.
///
/// # Errors
/// An empty frame.
pub fn lens(width_px: u32, height_px: u32) -> Result<LensProfile> {
    let frame = Frame::new(width_px, height_px, None)?;
    let channels = (0..CHANNELS.len()).map(|index| channel(index, &frame));
    let camera = Camera {
        focal_length_mm: Some(FOCAL_LENGTH_MM),
        f_number: Some(F_NUMBER),
        focus_distance: ObjectDistance::Metres(FOCUS_M),
        wavelength_nm: wavelengths_nm(),
        ..Camera::default()
    };
    let channels = channels.collect();
    Ok(profile(frame, width_px, camera, channels))
}

/// Returns the wavelength of each channel, nm.
pub(super) fn wavelengths_nm() -> BTreeMap<String, f64> {
    let names = CHANNELS.map(str::to_owned);
    names.into_iter().zip(WAVELENGTH_NM).collect()
}

/// Returns the profile of a designed lens for plates of `width_px`.
pub(super) fn profile(
    frame: Frame,
    width_px: u32,
    camera: Camera,
    channels: Vec<PupilChannel>,
) -> LensProfile {
    LensProfile {
        frame,
        pixel_pitch_um: Some(SENSOR_WIDTH_MM * 1e3 / f64::from(width_px)),
        camera,
        description: LensDescription::Pupil(channels),
        held_out: None,
        provenance: Provenance {
            program: concat!("seidel ", env!("CARGO_PKG_VERSION")).to_owned(),
            sources: vec!["built-in demo lens".to_owned()],
            settings: "designed, not measured".to_owned(),
            ..Provenance::default()
        },
    }
}

/// Returns the radius of the on-axis disc in design pixels per 1/m of vergence: Z2 R / M for a pupil in
/// the lens.
pub(super) fn defocus_px_per_dioptre(f_number: f64) -> f64 {
    let f_m = FOCAL_LENGTH_MM * 1e-3;
    let image_m = f_m / (1.0 - f_m / FOCUS_M);
    let pitch_m = SENSOR_WIDTH_MM * 1e-3 / DESIGN_WIDTH_PX;
    image_m * f_m / (2.0 * f_number) / pitch_m
}

fn channel(index: usize, frame: &Frame) -> PupilChannel {
    let scale = f64::from(frame.width_px()) / DESIGN_WIDTH_PX;
    let px = |value: f64| VergenceSeries::constant(value * scale);
    let slope = defocus_px_per_dioptre(F_NUMBER);
    PupilChannel {
        alpha: VergenceSeries::new(vec![ALPHA_FOCUS_PX[index] - slope / FOCUS_M, slope])
            .scaled(scale),
        beta: px(BETA_PX),
        gamma: px(GAMMA_PX),
        delta: px(DELTA_PX),
        phi: px(PHI_PX[index]),
        blur_variance_px2: VergenceSeries::constant(BLUR_VARIANCE_PX2 * scale * scale),
        magnification: VergenceSeries::constant(MAGNIFICATION[index]),
        distortion: VergenceSeries::constant(DISTORTION),
        ..channel_without_aberrations(CHANNELS[index])
    }
}

/// Returns channel `name` of a lens that is sharp everywhere.
pub(super) fn channel_without_aberrations(name: &str) -> PupilChannel {
    let zero = || VergenceSeries::constant(0.0);
    PupilChannel {
        name: name.to_owned(),
        alpha: zero(),
        beta: zero(),
        gamma: zero(),
        delta: zero(),
        phi: zero(),
        blur_variance_px2: zero(),
        effects: Vec::new(),
        magnification: zero(),
        distortion: zero(),
        measured_vergence: MEASURED_PER_M,
        stop_lever_m: 0.0,
        added: Vec::new(),
        picture: None,
        wavelength_px: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_core::{BlurField, FieldPoint, Predictor};

    #[test]
    fn blur_variances_are_positive_everywhere() {
        let lens = lens(1280, 720).expect("a frame");
        let read = LensProfile::from_json(&lens.to_json()).expect("a valid profile");
        assert_eq!(read.channel_names(), ["R", "G", "B"]);
        let predictor = Predictor::new(&lens).expect("a lens");
        let corner = FieldPoint::new(1.0, 0.5625);
        for channel in 0..3 {
            for step in 0..=100 {
                let vergence = f64::from(step) / 100.0;
                let placed = predictor.blur_at(channel, corner, vergence);
                let least = placed.blur.moments.least_variance();
                assert!(least > 0.0, "{channel} at {vergence}: {least}");
            }
        }
    }

    #[test]
    fn sizes_are_those_of_a_fast_prime() {
        let lens = lens(1280, 720).expect("a frame");
        let predictor = Predictor::new(&lens).expect("a lens");
        let sigma = |h: f64, metres: f64| {
            let placed = predictor.blur_at(1, FieldPoint::new(h, 0.0), 1.0 / metres);
            (placed.blur.moments.trace() / 2.0).sqrt()
        };
        assert!(sigma(0.0, FOCUS_M) < 0.8, "{}", sigma(0.0, FOCUS_M));
        for metres in [8.0, 30.0] {
            assert!((8.0..28.0).contains(&sigma(0.0, metres)));
            assert!(sigma(1.147, metres) > 1.2 * sigma(0.0, metres));
        }
        // Lateral colour at the corner.
        let at = |c| {
            let placed = predictor.blur_at(c, FieldPoint::new(1.0, 0.5625), 0.5);
            placed.displacement_px.0.hypot(placed.displacement_px.1)
        };
        assert!(
            (1.0..5.0).contains(&(at(0) - at(2)).abs()),
            "{}",
            at(0) - at(2)
        );
    }

    #[test]
    fn blur_scales_with_the_frame() {
        let (small, large) = (lens(320, 180), lens(1280, 720));
        let s1 = |l: Result<LensProfile>| {
            let lens = l.expect("a frame");
            let predictor = Predictor::new(&lens).expect("a lens");
            let on_axis = predictor.blur_at(1, FieldPoint::new(0.0, 0.0), 0.0);
            on_axis.blur.moments.mu20
        };
        assert!((s1(large) / s1(small) - 16.0).abs() < 1e-9);
    }
}
