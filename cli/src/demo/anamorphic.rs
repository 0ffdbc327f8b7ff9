//! The built-in anamorphic lens: a 2x front anamorphic with a taking lens of 50 mm.
//!
//! Its image is half as wide as the scene. Cylinders in front of the aperture halve the focal length and the entrance pupil
//! along x, so a defocused disc is a quarter as wide as it is high on the sensor, and half as wide on the desqueezed plate.
//! The terms of the double-plane wavefront are those of docs/background/model.md section 12.

use seidel_core::profile::{ProfileEffect, PupilChannel};
use seidel_core::{Camera, Frame, LensProfile, ObjectDistance, Result};
use seidel_optics::effects::{DoublePlane, Effect};
use seidel_optics::lens::VergenceSeries;

use super::lens::{
    CHANNELS, DESIGN_WIDTH_PX, FOCAL_LENGTH_MM, FOCUS_M, channel_without_aberrations,
    defocus_px_per_dioptre, profile, wavelengths_nm,
};

/// Width of the scene over the width of its image, for the same height.
pub const SQUEEZE: f64 = 2.0;
/// F-number, alike in both sections.
const F_NUMBER: f64 = 1.4;

/// Defocus on the focused plane by channel (axial colour), px.
const ALPHA_FOCUS_PX: [f64; 3] = [0.6, 0.0, 1.2];
/// Spherical aberration, px.
const BETA_PX: f64 = 1.0;
/// Coma by channel, px per half frame width.
const PHI_PX: [f64; 3] = [-0.8, -0.6, -0.5];
/// Magnification by channel, relative to the mean (lateral colour).
const MAGNIFICATION: [f64; 3] = [0.0015, 0.0, -0.002];
/// Terms of the double-plane wavefront, px: field curvature of the cylinders along x, of the other section along y, and coma
/// of the cylinders.
const TERMS_PX: [(&str, f64); 3] = [("w2020", -2.5), ("w0202", 1.5), ("w3010", 0.8)];
/// Variance of the symmetric blur, px².
const BLUR_VARIANCE_PX2: f64 = 0.1;

/// Returns the built-in anamorphic lens for desqueezed plates of `width_px` x `height_px`.
///
/// # Errors
/// An empty frame.
pub fn anamorphic_lens(width_px: u32, height_px: u32) -> Result<LensProfile> {
    let frame = Frame::new((f64::from(width_px) / SQUEEZE) as u32, height_px, None)?;
    let camera = Camera {
        focal_length_mm: Some(FOCAL_LENGTH_MM),
        f_number: Some(F_NUMBER),
        focus_distance: ObjectDistance::Metres(FOCUS_M),
        wavelength_nm: wavelengths_nm(),
        squeeze: Some(SQUEEZE),
        ..Camera::default()
    };
    let channels = (0..CHANNELS.len()).map(|index| channel(index, width_px));
    let channels = channels.collect();
    Ok(profile(frame, width_px, camera, channels))
}

fn channel(index: usize, width_px: u32) -> PupilChannel {
    let scale = f64::from(width_px) / DESIGN_WIDTH_PX;
    let slope = defocus_px_per_dioptre(F_NUMBER) * scale;
    let px = |value: f64| VergenceSeries::constant(value * scale);
    PupilChannel {
        alpha: VergenceSeries::new(vec![ALPHA_FOCUS_PX[index] * scale - slope / FOCUS_M, slope]),
        beta: px(BETA_PX),
        phi: px(PHI_PX[index]),
        blur_variance_px2: VergenceSeries::constant(BLUR_VARIANCE_PX2 * scale * scale),
        magnification: VergenceSeries::constant(MAGNIFICATION[index]),
        effects: vec![two_planes(slope, scale)],
        ..channel_without_aberrations(CHANNELS[index])
    }
}

/// Returns the terms in which the sections along x and y differ, where defocus along y rises by `slope` with vergence.
fn two_planes(slope: f64, scale: f64) -> ProfileEffect {
    let less = slope * (1.0 / (SQUEEZE * SQUEEZE) - 1.0);
    let values = DoublePlane.parameters().iter().map(|parameter| {
        let term = TERMS_PX.iter().find(|(name, _)| *name == parameter.name);
        match term {
            Some((_, value)) => VergenceSeries::constant(value * scale),
            // Defocus along x beyond that along y.
            None if parameter.name == "w2000" => VergenceSeries::new(vec![-less / FOCUS_M, less]),
            None => VergenceSeries::constant(0.0),
        }
    });
    ProfileEffect {
        effect: &DoublePlane,
        values: values.collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_core::{BlurField, FieldPoint, Predictor};

    #[test]
    fn discs_are_a_quarter_as_wide_as_high_on_the_sensor() {
        let lens = anamorphic_lens(1280, 720).expect("a frame");
        assert_eq!(lens.frame.width_px(), 640);
        let predictor = Predictor::new(&lens).expect("a lens");
        for metres in [1.2, 30.0] {
            let placed = predictor.blur_at(1, FieldPoint::new(0.0, 0.0), 1.0 / metres);
            let moments = placed.blur.moments;
            let ratio = (moments.mu20 / moments.mu02).sqrt();
            assert!((0.2..0.3).contains(&ratio), "{metres} m: {ratio}");
        }
    }
}
