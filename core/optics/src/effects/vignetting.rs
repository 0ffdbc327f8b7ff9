//! Mechanical vignetting: the barrel clips oblique pencils.

use super::{ControlRatios, Effect, Parameter, ScenePoint, Scope, SearchStart};
use crate::lens::{LocalPupil, Stop, VergenceSeries};

/// `vignetting`: two more circles that light must pass, one before the aperture and one behind it,
/// that move over the pupil as the field position moves from the axis.
///
/// Discs out of focus become cat's eyes towards the corners, and all blur there narrows. Mistaken for
/// astigmatism and for oblique spherical aberration. A circle of radius r (pupil radii) stands at
/// s X, X the field position in half frame widths: seen from the image a stop in front of the
/// aperture moves one way, one behind it the other. Where the camera is known the shift says how far
/// off the pupil the stop stands, and with it what it does at other object distances. Lengths are in
/// pupil radii, so the numbers do not depend on channel; a neutral circle is large and stands still.
#[derive(Debug, Clone, Copy, Default)]
pub struct Vignetting;

/// A radius that clips nothing where shifts are sane.
const WIDE: f64 = 4.0;

const fn radius(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter {
        name,
        unit: "pupil radii",
        meaning,
        neutral: WIDE,
        least: 0.2,
        most: WIDE,
        step: 0.02,
        scope: Scope::Lens,
    }
}

const fn shift(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter {
        name,
        unit: "pupil radii per half frame width",
        meaning,
        neutral: 0.0,
        least: -2.0,
        most: 2.0,
        step: 0.02,
        scope: Scope::Lens,
    }
}

static PARAMETERS: [Parameter; 4] = [
    radius("radius_1", "radius of the first circle"),
    shift("shift_1", "how far the first circle moves with the field"),
    radius("radius_2", "radius of the second circle"),
    shift("shift_2", "how far the second circle moves with the field"),
];

impl Effect for Vignetting {
    fn id(&self) -> &'static str {
        "vignetting"
    }

    fn summary(&self) -> &'static str {
        "the barrel clips oblique pencils: discs become cat's eyes towards the corners"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
        for circle in values.chunks_exact(2) {
            // A stop at distance L before the pupil (behind it where negative) is s times the lever
            // off; light that diverges from a near point meets it closer to the axis by 1 - L v.
            let nearer = 1.0 - circle[1] * point.stop_lever_m * point.vergence_per_m;
            let scale = 1.0 / nearer.max(0.1);
            pupil.clip(Stop {
                centre: [
                    scale * circle[1] * point.at.x,
                    scale * circle[1] * point.at.y,
                ],
                radius: scale * circle[0],
            });
        }
    }

    // One circle, before the aperture or behind it, then both.
    fn starts(&self) -> Vec<SearchStart> {
        let one = [true, true, false, false];
        let single = [0.5, -0.5, 0.2, -0.2].map(|shift| SearchStart {
            values: vec![1.0, shift, WIDE, 0.0],
            free: one.to_vec(),
        });
        let both = SearchStart::all_free(&[1.0, 0.5, 1.0, -0.5]);
        single.into_iter().chain([both]).collect()
    }

    // The circles stay as large as they are and move with the field angle X / Z2. One that stands still
    // needs no more than the radius that clips nothing.
    fn rescale(&self, values: &[VergenceSeries], to: ControlRatios) -> Vec<VergenceSeries> {
        let circles = values.chunks_exact(2);
        circles
            .flat_map(|circle| {
                let radius = circle[0].scaled(1.0 / to.pupil);
                let shift = circle[1].scaled(1.0 / (to.pupil * to.image_distance));
                let still = shift.coefficients.iter().all(|c| *c == 0.0);
                let radius = match radius.coefficients[..] {
                    [only] if still && only > WIDE => VergenceSeries::constant(WIDE),
                    _ => radius,
                };
                [radius, shift]
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn discs_are_cats_eyes_in_the_corner_only() {
        let values = [1.0, 0.5, 1.0, -0.5];
        let moments = |x| {
            behind(&Vignetting, &values, place(x, 0.0), disc(4.0))
                .moments()
                .0
        };
        let (middle, corner) = (moments(0.0), moments(1.0));
        assert!((middle.mu20 - 4.0).abs() < 1e-9 && (middle.mu02 - 4.0).abs() < 1e-9);
        // A lens-shaped pupil, narrow along the meridian.
        assert!(corner.mu20 < 0.3 * middle.mu20, "{corner:?}");
        assert!(corner.mu20 < 0.5 * corner.mu02, "{corner:?}");
    }

    #[test]
    fn one_circle_cuts_one_side() {
        let values = [1.0, 0.5, WIDE, 0.0];
        let pupil = behind(&Vignetting, &values, place(0.0, 0.8), disc(4.0));
        assert!(pupil.passes([0.0, 0.9]) && !pupil.passes([0.0, -0.9]));
        assert!(pupil.centroid()[1] > 0.5);
    }
}
