//! Camera motion during the exposure.

use super::{
    ControlRatios, Description, Effect, Fitted, Parameter, ScenePoint, SearchStart, Symmetry,
};
use crate::lens::{LocalPupil, VergenceSeries};

/// `motion`: linear motion blur.
///
/// # Appearance
/// The same streak over the whole field, in all channels and at all distances.
///
/// # Similar effects
/// Astigmatism, which turns with the meridian and with focus; `pixel_footprint`, if the streak is short.
///
/// # Model
/// The image moves by (`x`, `y`) px at constant speed; the centre of the path lies (`shift_x`, `shift_y`) px off the
/// position at rest. The transfer function is sin(pi f.d) / (pi f.d).
#[derive(Debug, Clone, Copy, Default)]
pub struct Motion;

const fn length(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "px", meaning).within(-100.0, 100.0)
}

const PARAMETERS: [Parameter; 4] = [
    length("x", "motion of the image along x"),
    length("y", "motion of the image along y"),
    length("shift_x", "offset of the centre of the path along x"),
    length("shift_y", "offset of the centre of the path along y"),
];

impl Effect for Motion {
    fn description(&self) -> &'static Description {
        &Description {
            id: "motion",
            summary: "the camera moved in the exposure: the same streak everywhere, in every channel",
            title: "camera motion",
            meaning: "Camera or target moved during the exposure: the same streak everywhere, in every channel.",
            action: "Re-shoot from a firm support with a remote release and a shorter exposure. Do not keep this in the profile: it belongs to these pictures, not to the lens.",
            parameters: &PARAMETERS,
            symmetry: Symmetry::None,
            shorter_exposure: "the streak shortens",
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let streak = fitted.vector("x", "y")?;
        let angle = streak.y.atan2(streak.x).to_degrees().rem_euclid(180.0);
        Some(format!(
            "a streak of {}, {angle:.0} degrees from image x towards y",
            streak.quantity(1.0, "px")
        ))
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
        for (streak, value) in pupil.sensor.streak_px.iter_mut().zip(values) {
            *streak += value;
        }
    }

    fn chief_ray(&self, values: &[f64], _point: ScenePoint) -> [f64; 2] {
        [values[2], values[3]]
    }

    // Opposite paths give the same streak, so half of the directions suffice.
    fn starts(&self) -> Vec<SearchStart> {
        [[2.0, 0.0], [0.0, 2.0], [1.5, 1.5], [1.5, -1.5]]
            .map(|[x, y]| SearchStart::all_free(&[x, y, 0.0, 0.0]))
            .to_vec()
    }

    // The camera turns by an angle; the path is that angle times Z2.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let each = values.iter();
        each.map(|series| series.scaled(ratios.image_distance))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn the_streak_is_the_same_everywhere() {
        let values = [3.0, -1.5, 0.5, 0.25];
        for (x, y) in [(0.0, 0.0), (0.9, -0.3)] {
            let (still, _) = disc(2.0).moments();
            let (moved, centroid) = behind(&Motion, &values, place(x, y), disc(2.0)).moments();
            assert!((moved.mu20 - still.mu20 - 9.0 / 12.0).abs() < 1e-12);
            assert!((moved.mu11 - still.mu11 + 4.5 / 12.0).abs() < 1e-12);
            assert!((moved.mu02 - still.mu02 - 2.25 / 12.0).abs() < 1e-12);
            assert!(centroid[0].abs() < 1e-12, "the centre of the path stays");
            assert_eq!(Motion.chief_ray(&values, place(x, y)), [0.5, 0.25]);
        }
    }
}
