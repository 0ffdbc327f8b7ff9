//! Diffraction.

use super::{ControlRatios, Description, Effect, Fitted, Parameter, ScenePoint, SearchStart};
use crate::lens::{LocalPupil, VergenceSeries};

/// `diffraction`: light is drawn as a wave.
///
/// # Appearance
/// An Airy pattern of radius 1.22 N times the wavelength in focus; fringes along edges and caustics elsewhere. Wider for
/// red and for small apertures, the same over the whole field.
///
/// # Similar effects
/// The symmetric blur of the lens, which does not depend on wavelength; `pixel_footprint`.
///
/// # Model
/// W in px is 2 `f_number` wavelength times the path difference in waves (Born and Wolf, sections 8.5.2 and 9.1).
#[derive(Debug, Clone, Copy, Default)]
pub struct Diffraction;

/// Wavelength over pixel pitch if either is unknown: green light on pixels of 5 um.
const WAVELENGTH_PX: f64 = 0.11;

const PARAMETERS: [Parameter; 1] = [Parameter::new(
    "f_number",
    "1",
    "f-number of the cone of light at the sensor; 0 for rays",
)
.within(0.0, 64.0)
.step(0.2)];

impl Effect for Diffraction {
    fn description(&self) -> &'static Description {
        &Description {
            id: "diffraction",
            summary: "light is a wave: an Airy pattern, wider for red and for small apertures",
            title: "diffraction",
            meaning: "The stop is so small against the pixels that light spreads as a wave, in an Airy pattern.",
            action: "Use corrected.json. Make sure that f-number, pixel pitch and wavelengths of the profile are those of the camera.",
            parameters: &PARAMETERS,
            two_stops_down: "the blur grows",
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let number = fitted.of("f_number")?;
        Some(format!("as at f/{}", number.quantity(1.0, "")))
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        let &[f_number] = values else {
            panic!("one value a parameter");
        };
        if f_number > 0.0 {
            let wavelength_px = if point.wavelength_px > 0.0 {
                point.wavelength_px
            } else {
                WAVELENGTH_PX
            };
            pupil.wave_px = 2.0 * f_number * wavelength_px;
        }
    }

    fn starts(&self) -> Vec<SearchStart> {
        [2.8, 5.6, 11.0]
            .map(|n| SearchStart::all_free(&[n]).likely())
            .to_vec()
    }

    // N = Z2 / (2 R).
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        vec![values[0].scaled(ratios.image_distance / ratios.pupil)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, point};

    fn wave(f_number: f64, wavelength_px: f64) -> f64 {
        let at = ScenePoint {
            wavelength_px,
            ..point()
        };
        behind(&Diffraction, &[f_number], at, disc(0.0)).wave_px
    }

    #[test]
    fn waves_are_longer_for_red_and_for_small_apertures() {
        assert!((wave(8.0, 0.125) - 2.0).abs() < 1e-12);
        assert!(wave(8.0, 0.13) > wave(8.0, 0.09) && wave(16.0, 0.1) > wave(8.0, 0.1));
        assert!(
            wave(8.0, 0.0) > 0.0,
            "a wavelength is taken where none is known"
        );
    }
}
