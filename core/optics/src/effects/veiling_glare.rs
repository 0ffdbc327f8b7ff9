//! Veiling glare: scattered light.

use super::amount::joined;
use super::{Description, Effect, Fitted, Parameter, ScenePoint, Scope, SearchStart};
use crate::lens::LocalPupil;
use crate::sensor::Halo;

/// `veiling_glare`: a share of the light scatters far.
///
/// # Appearance
/// A faint, wide halo around every point, independent of focus and field, and stronger in one channel for halation.
/// Contrast drops near bright areas.
///
/// # Similar effects
/// Defocus of a wide aperture; the skirts of spherical aberration.
///
/// # Model
/// A `share` of the light has the density (1 + r²/radius²)^-steepness (Moffat, Astronomy and Astrophysics 3, 1969): the
/// glare spread function that ISO 9358 measures with black patches. It is attributed to sensor and cover glass, which do not
/// depend on pupil and focus.
#[derive(Debug, Clone, Copy, Default)]
pub struct VeilingGlare;

const PARAMETERS: [Parameter; 3] = [
    Parameter::new("share", "1", "share of the light that scatters")
        .within(0.0, 0.9)
        .step(0.005)
        .scope(Scope::Channel),
    Parameter::new("radius", "px", "radius of the halo")
        .neutral_at(4.0)
        .within(0.5, 200.0)
        .step(0.2),
    Parameter::new("steepness", "1", "exponent of the decay of the halo")
        .neutral_at(2.0)
        .within(1.05, 8.0)
        .step(0.1),
];

impl Effect for VeilingGlare {
    fn description(&self) -> &'static Description {
        &Description {
            id: "veiling_glare",
            summary: "light scatters in lens and sensor: a faint wide halo around every point",
            title: "veiling glare",
            meaning: "Light scatters in lens or sensor: a faint wide halo around every point.",
            action: "Clean front and rear element and filters, shade the lens, and re-shoot. If the halo stays, use corrected.json.",
            parameters: &PARAMETERS,
            dark_surround: "its halo goes on far beyond the tile",
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let shares = fitted.by_channel("share").map(|(channel, share)| {
            let share = share.quantity(100.0, "%");
            format!("{share} of the light of channel {channel}")
        });
        let shares = joined(shares.collect())?;
        let radius = fitted.of("radius").map_or(String::new(), |radius| {
            format!(", in a halo of radius {}", radius.quantity(1.0, "px"))
        });
        Some(format!("{shares} scatters{radius}"))
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        let &[share, radius_px, steepness] = values else {
            panic!("one value a parameter");
        };
        if share > 0.0 {
            pupil.sensor.halo = Halo {
                share,
                radius_px,
                steepness,
                stretch_x: 1.0,
            };
        }
    }

    fn starts(&self) -> Vec<SearchStart> {
        [3.0, 8.0]
            .map(|radius| SearchStart::all_free(&[0.1, radius, 2.0]))
            .to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn the_halo_has_a_share_for_each_channel() {
        assert_eq!(PARAMETERS[0].scope, Scope::Channel);
        assert_eq!(PARAMETERS[1].scope, Scope::Lens);
        for (alpha, x) in [(0.0, 0.0), (4.0, 0.9)] {
            let values = [0.2, 6.0, 1.5];
            let pupil = behind(&VeilingGlare, &values, place(x, 0.0), disc(alpha));
            let halo = pupil.sensor.halo;
            assert_eq!([halo.share, halo.radius_px, halo.steepness], values);
            assert!(!pupil.sensor.is_ideal());
            // Rays do not change.
            assert_eq!(pupil.moments(), disc(alpha).moments());
        }
    }

    #[test]
    fn zero_share_leaves_the_sensor_ideal() {
        let pupil = behind(&VeilingGlare, &[0.0, 9.0, 3.0], place(0.0, 0.0), disc(1.0));
        assert_eq!(pupil, disc(1.0));
    }
}
