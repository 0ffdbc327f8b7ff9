//! A central obstruction: the secondary mirror of a catadioptric lens.

use super::{ControlRatios, Description, Effect, FitPart, Parameter, ScenePoint, SearchStart};
use crate::lens::{LocalPupil, Stop, VergenceSeries};

/// `obstruction`: an opaque disc in the middle of the pupil.
///
/// # Appearance
/// Defocused discs are rings with sharp inner edges on both sides of focus. In focus, contrast of fine detail drops.
///
/// # Similar effects
/// `apodisation` with a bright rim, which has no inner edge.
///
/// # Model
/// No light passes within `radius` of the point `shift` X, with X in half frame widths and lengths in pupil radii: the
/// shadow of a disc in front of the aperture moves over the pupil with the field position.
#[derive(Debug, Clone, Copy, Default)]
pub struct Obstruction;

const PARAMETERS: [Parameter; 2] = [
    Parameter::new("radius", "pupil radii", "radius of the opaque disc")
        .within(0.0, 0.9)
        .step(0.01),
    Parameter::new(
        "shift",
        "pupil radii per half frame width",
        "shift of the disc with the field",
    )
    .within(-2.0, 2.0)
    .step(0.02),
];

impl Effect for Obstruction {
    fn description(&self) -> &'static Description {
        &Description {
            id: "obstruction",
            summary: "a mirror stands in the middle of the pupil: discs are rings",
            title: "a central obstruction",
            meaning: "The middle of the pupil is dark: out-of-focus discs are rings.",
            action: "Check that the lens is a mirror lens, or that nothing stands before it.",
            parameters: &PARAMETERS,
            // A lens is designed so.
            is_cause: false,
            fit: FitPart {
                used: 2,
                shared: true,
                // Many, so that lenses without one are known by a glance.
                starts: || (1..8).map(|k| vec![0.1 * f64::from(k), 0.0]).collect(),
                worth: 0.1,
                ..FitPart::NONE
            },
            ..Description::DEFAULT
        }
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        let &[radius, shift] = values else {
            panic!("one value a parameter");
        };
        pupil.obstruct(Stop {
            centre: [shift * point.at.x, shift * point.at.y],
            radius,
        });
    }

    fn starts(&self) -> Vec<SearchStart> {
        vec![SearchStart::all_free(&[0.4, 0.1])]
    }

    // The disc stays in its place.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        vec![
            values[0].scaled(1.0 / ratios.pupil),
            values[1].scaled(1.0 / (ratios.pupil * ratios.image_distance)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn the_middle_of_the_pupil_is_dark_and_moves_with_the_field() {
        let dark =
            |x, u: [f64; 2]| !behind(&Obstruction, &[0.4, 0.5], place(x, 0.0), disc(4.0)).passes(u);
        assert!(dark(0.0, [0.0, 0.0]) && dark(0.0, [0.39, 0.0]) && !dark(0.0, [0.41, 0.0]));
        assert!(dark(1.0, [0.8, 0.0]) && !dark(1.0, [0.0, 0.0]));
    }
}
