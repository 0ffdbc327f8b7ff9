//! Nonlinear pixel values.

use super::{Description, Effect, Fitted, Parameter, ScenePoint, SearchStart};
use crate::lens::LocalPupil;
use crate::sensor::Tone;

/// `tone_curve`: pixel values follow light by a curve, or are clipped.
///
/// # Appearance
/// Bright cores are compressed or expanded relative to faint skirts, or flat on top. Over the whole field, most in sharp
/// PSFs; no light distribution explains it.
///
/// # Similar effects
/// `veiling_glare`; spherical aberration.
///
/// # Model
/// With white at one, l becomes l^gamma (1 + knee) / (1 + knee l^gamma), clipped at `clip`: a power law with the shoulder
/// of Reinhard et al. (SIGGRAPH 2002). Debevec and Malik (SIGGRAPH 1997) describe the response curves of cameras.
#[derive(Debug, Clone, Copy, Default)]
pub struct ToneCurve;

/// Value of `clip` that means no clipping.
const NO_CLIP: f64 = 100.0;

const PARAMETERS: [Parameter; 3] = [
    Parameter::new("gamma", "1", "exponent; below one brightens dark values")
        .neutral_at(1.0)
        .within(0.3, 3.0)
        .step(0.01),
    Parameter::new("knee", "1", "compression of bright values")
        .within(-0.6, 8.0)
        .step(0.02),
    Parameter::new("clip", "white", "largest value; 100 for none")
        .neutral_at(NO_CLIP)
        .within(0.05, NO_CLIP)
        .step(0.02),
];

impl Effect for ToneCurve {
    fn description(&self) -> &'static Description {
        &Description {
            id: "tone_curve",
            summary: "values are not proportional to light: cores compressed against skirts, or clipped",
            title: "a tone curve",
            meaning: "Pixel values are not proportional to light: bright cores are compressed, stretched or clipped.",
            action: "Develop the pictures scene-linear, without picture profile, and expose so that nothing clips. Then measure the PSFs again.",
            parameters: &PARAMETERS,
            shorter_exposure: "bright cores are compressed less",
            // It acts on the light of the plate, not on that of PSFs.
            in_pictures: false,
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let gamma = fitted.of("gamma")?;
        Some(format!(
            "values follow light to the power {}",
            gamma.quantity(1.0, "")
        ))
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        let &[gamma, knee, clip] = values else {
            panic!("one value a parameter");
        };
        let tone = Tone {
            gamma,
            knee,
            clip: if clip >= NO_CLIP { f64::INFINITY } else { clip },
        };
        if !tone.is_linear() {
            pupil.sensor.tone = tone;
        }
    }

    // The exponent, the shoulder, clipping, exponent and shoulder, then clipping elsewhere: only pixels near the right level show
    // in which direction it lies. A part of the way from no clipping is none.
    fn starts(&self) -> Vec<SearchStart> {
        let from = |values: [f64; 3], free: [bool; 3]| SearchStart::new(&values, &free);
        let clipped = |at: f64| from([1.0, 0.0, at], [false, false, true]).likely();
        vec![
            from([0.9, 0.0, NO_CLIP], [true, false, false]),
            from([1.0, 0.3, NO_CLIP], [false, true, false]),
            clipped(0.7),
            from([0.9, 0.3, NO_CLIP], [true, true, false]),
            clipped(0.5),
            clipped(0.35),
            clipped(0.85),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    fn value(values: [f64; 3], light: f64) -> f64 {
        let pupil = behind(&ToneCurve, &values, place(0.2, 0.1), disc(3.0));
        assert_eq!(pupil.wavefront, disc(3.0).wavefront);
        pupil.sensor.tone.apply(light)
    }

    #[test]
    fn cores_are_compressed_against_skirts_or_stretched_or_flat() {
        let against = |values| value(values, 0.9) / value(values, 0.1);
        assert!(against([0.8, 0.0, NO_CLIP]) < 9.0 && against([1.2, 0.0, NO_CLIP]) > 9.0);
        assert!(against([1.0, 0.5, NO_CLIP]) < 9.0 && against([1.0, -0.3, NO_CLIP]) > 9.0);
        let clipped = [1.0, 0.0, 0.7];
        assert_eq!([0.9, 0.8, 0.5].map(|l| value(clipped, l)), [0.7, 0.7, 0.5]);
        // White stays one, and brighter values are not clipped by default.
        assert!((value([0.8, 0.5, NO_CLIP], 1.0) - 1.0).abs() < 1e-12);
        assert_eq!(value([1.0, 0.0, NO_CLIP], 500.0), 500.0);
    }
}
