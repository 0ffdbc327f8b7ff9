//! Mechanical vignetting: the barrel clips oblique pencils.

use super::{
    ControlRatios, Description, Effect, FieldNeed, FitPart, Fitted, Parameter, PupilScale,
    ScenePoint, SearchStart,
};
use crate::lens::{LocalPupil, Stop, VergenceSeries};

/// `vignetting`: two more circular stops, one in front of the aperture and one behind it, that shift over the pupil with
/// the field position.
///
/// # Appearance
/// Defocused discs become cat's eyes towards the corners, where all blur narrows.
///
/// # Similar effects
/// Astigmatism; oblique spherical aberration.
///
/// # Model
/// A circle of radius r is centred at s X, with X in half frame widths and lengths in pupil radii. Seen from the image,
/// a stop in front of the aperture shifts one way, one behind it the other. If the camera is known, the shift gives the
/// distance of the stop from the pupil, and with it the change with object distance. A neutral circle is large and does
/// not shift.
#[derive(Debug, Clone, Copy, Default)]
pub struct Vignetting;

/// Neutral radius: clips nothing for realistic shifts.
const WIDE: f64 = 4.0;

const fn radius(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "pupil radii", meaning)
        .neutral_at(WIDE)
        .within(0.2, WIDE)
        .step(0.02)
}

const fn shift(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "pupil radii per half frame width", meaning)
        .within(-2.0, 2.0)
        .step(0.02)
}

const PARAMETERS: [Parameter; 4] = [
    radius("radius_1", "radius of the first circle"),
    shift("shift_1", "shift of the first circle with the field"),
    radius("radius_2", "radius of the second circle"),
    shift("shift_2", "shift of the second circle with the field"),
];

/// Largest difference of a circle from the rim of the pupil, in radius and in shift, that makes it an image of the iris.
const IRIS_TOLERANCE: f64 = 0.05;

/// Returns whether a circle of this `radius` and `shift` is the iris itself, seen a little deformed from off the axis. It then
/// opens and closes with the iris; the barrel does not.
fn is_iris(radius: f64, shift: f64) -> bool {
    (radius - 1.0).abs() < IRIS_TOLERANCE && shift.abs() < IRIS_TOLERANCE
}

impl Effect for Vignetting {
    fn description(&self) -> &'static Description {
        &Description {
            id: "vignetting",
            summary: "the barrel clips oblique pencils: discs become cat's eyes towards the corners",
            title: "vignetting",
            meaning: "The barrel, a hood or a filter ring clips oblique light: out-of-focus discs become cat's eyes towards the corners.",
            action: "Remove hood and filters and look again. If it stays, it is the lens's own: use corrected.json, or fit again with the extended model.",
            parameters: &PARAMETERS,
            field_need: FieldNeed::Radii,
            far_out_of_focus: Some("only the disc in the corner is cut"),
            two_stops_down: "the cat's eye becomes round",
            other_side_of_focus: "the cat's eye turns over",
            // A smaller iris looks like a stop that does not move.
            contains: &[&PupilScale],
            fit: FitPart {
                used: 4,
                shared: true,
                starts: stops,
                worth: 0.01,
                from_edges: true,
                ..FitPart::NONE
            },
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        fitted.of("radius_1")?;
        Some(format!(
            "{:.0} % of the pupil is clipped at the side of the frame, {:.0} % in the middle",
            100.0 * clipped(fitted, 1.0),
            100.0 * clipped(fitted, 0.0)
        ))
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
        for circle in values.chunks_exact(2).filter(|circle| circle[0] < WIDE) {
            // The stop lies L = s times the lever in front of the pupil (behind it if negative). Light that
            // diverges from a near point passes it closer to the axis by the factor 1 - L v.
            let nearer = 1.0 - circle[1] * point.stop_lever_m * point.vergence_per_m;
            let scale = 1.0 / nearer.max(0.1);
            let stop = Stop {
                centre: [
                    scale * circle[1] * point.at.x,
                    scale * circle[1] * point.at.y,
                ],
                radius: scale * circle[0],
            };
            if is_iris(circle[0], circle[1]) {
                pupil.clip_iris(stop);
            } else {
                pupil.clip(stop);
            }
        }
    }

    // One circle, in front of the aperture or behind it, then both.
    fn starts(&self) -> Vec<SearchStart> {
        let one = [true, true, false, false];
        let single =
            [0.5, -0.5, 0.2, -0.2].map(|shift| SearchStart::new(&[1.0, shift, WIDE, 0.0], &one));
        let both = SearchStart::all_free(&[1.0, 0.5, 1.0, -0.5]);
        single.into_iter().chain([both]).collect()
    }

    // The circles keep their size and shift with the field angle X / Z2. The radius of a neutral circle is
    // limited to the largest valid one.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let circles = values.chunks_exact(2);
        circles
            .flat_map(|circle| {
                let radius = circle[0].scaled(1.0 / ratios.pupil);
                let shift = circle[1].scaled(1.0 / (ratios.pupil * ratios.image_distance));
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

/// Returns the share of the pupil outside the clipping circles at field radius `field`.
fn clipped(fitted: Fitted, field: f64) -> f64 {
    const STEPS: i32 = 100;
    let circles = [("radius_1", "shift_1"), ("radius_2", "shift_2")].map(|(radius, shift)| {
        let radius = fitted.of(radius).map_or(f64::INFINITY, |v| v.value);
        (radius, fitted.number(shift) * field)
    });
    let (mut inside, mut passes) = (0, 0);
    for (x, y) in (-STEPS..=STEPS).flat_map(|x| (-STEPS..=STEPS).map(move |y| (x, y))) {
        let (x, y) = (
            f64::from(x) / f64::from(STEPS),
            f64::from(y) / f64::from(STEPS),
        );
        if x.hypot(y) <= 1.0 {
            inside += 1;
            passes += i32::from(circles.iter().all(|(r, s)| (x - s).hypot(y) <= *r));
        }
    }
    1.0 - f64::from(passes) / f64::from(inside)
}

/// Returns initial stops of fits: radius and shift of a front and a rear one. One alone clips half way to the corner; two begin
/// to clip on the axis, half way to the corner, or near it.
fn stops() -> Vec<Vec<f64>> {
    let neutral = [WIDE, 0.0];
    let one = [[[1.05, 0.3], neutral], [neutral, [1.05, -0.3]]];
    let two = [[1.0, 0.15], [1.0, 0.5], [1.4, 0.6], [1.8, 0.9]];
    let two = two.map(|[radius, shift]| [[radius, shift], [radius, -shift]]);
    one.iter().chain(&two).map(|stops| stops.concat()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn discs_are_cats_eyes_in_the_corners_only() {
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

    #[test]
    fn a_circle_at_the_rim_opens_with_the_iris_and_the_barrel_does_not() {
        let reaches = |radius| {
            let at = place(1.0, 0.0);
            let pupil = behind(&Vignetting, &[radius, 0.01, WIDE, 0.0], at, disc(4.0));
            pupil.with_pupil(1.5).passes([0.0, 0.98])
        };
        assert!(reaches(1.001));
        assert!(!reaches(1.1));
    }
}
