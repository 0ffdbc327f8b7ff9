//! Iris blades: a polygonal pupil.

use std::f64::consts::TAU;

use super::amount::quantity;
use super::{
    ControlRatios, Description, Effect, FitPart, Fitted, Parameter, PupilScale, ScenePoint,
    SearchStart, Symmetry,
};
use crate::lens::{LocalPupil, MAX_STOPS, Stop, VergenceSeries};

/// `aperture_polygon`: the pupil is a polygon of `blades` sides.
///
/// # Appearance
/// Defocused discs are polygons, the same over the whole field. They are point-mirrored through focus, which shows the
/// side of focus if the number of blades is odd.
///
/// # Similar effects
/// Higher-order astigmatism and coma; `apodisation` if corners are small.
///
/// # Model
/// One corner points `rotation_deg` from image x towards y. Corners lie `reach` pupil radii from the axis. Sides are arcs
/// of curvature `roundness` / reach: straight at 0, one circle at 1. An inverted pupil turns the polygon by 180 degrees.
#[derive(Debug, Clone, Copy, Default)]
pub struct AperturePolygon;

/// Smallest number of blades that bounds a pupil; fewer mean a round iris.
const FEWEST: f64 = 3.0;
/// Largest number of blades.
const MOST: f64 = 13.0;
/// Curvature of straight blades, per pupil radius: stops are circles.
const STRAIGHT: f64 = 1e-3;
/// Relative distance of the rim beyond the corners, so that only the blades bound the pupil.
const CLEARANCE: f64 = 1e-6;

const PARAMETERS: [Parameter; 4] = [
    Parameter::new(
        "blades",
        "1",
        "number of blades, counted; 0 for a round iris",
    )
    .within(0.0, MOST)
    .step(1.0),
    Parameter::new(
        "rotation_deg",
        "degrees",
        "direction of one corner, from x towards y",
    )
    .within(-180.0, 180.0)
    .step(1.0),
    Parameter::new(
        "reach",
        "pupil radii",
        "distance of the corners from the axis",
    )
    .neutral_at(1.0)
    .within(0.5, 1.5)
    .step(0.01),
    Parameter::new(
        "roundness",
        "1",
        "curvature of the blades: 0 straight, 1 one circle",
    )
    .within(0.0, 1.0)
    .step(0.05),
];

const _: () = assert!(
    1 + 3 * 2 + MOST as usize <= MAX_STOPS,
    "rim; vignetting of the lens, added to it, and tried by a diagnosis; blades"
);

impl Effect for AperturePolygon {
    fn description(&self) -> &'static Description {
        &Description {
            id: "aperture_polygon",
            summary: "the iris has blades: discs are polygons, mirrored through focus",
            title: "iris blades",
            meaning: "The iris is a polygon: out-of-focus highlights have corners.",
            action: "Use corrected.json at this f-number, or fit again with the extended model to PSFs far out of focus. Profiles of other stops need PSFs of their own.",
            parameters: &PARAMETERS,
            symmetry: Symmetry::None,
            far_out_of_focus: Some("the discs have corners"),
            two_stops_down: "the polygon shows in full",
            other_side_of_focus: "the polygon turns upside down",
            // A smaller iris looks like a polygon of arcs of one circle.
            contains: &[&PupilScale],
            // Two irises would need more stops than a pupil can have.
            is_unique: true,
            fit: FitPart {
                used: 4,
                // The number of blades is counted, and the distance of the corners is one with the size of the pupil.
                fixed: &[0, 2],
                shared: true,
                starts: irises,
                worth: 0.1,
                ..FitPart::NONE
            },
            ..Description::DEFAULT
        }
    }

    fn amount(&self, values: &[f64]) -> Option<String> {
        let &[blades, rotation, _, roundness] = values else {
            return None;
        };
        Some(format!(
            "{blades:.0} blades, a corner at {rotation:.0} degrees, roundness {roundness:.2}"
        ))
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let rotation = fitted.of("rotation_deg")?;
        let shape = fitted.of("roundness").map_or(String::new(), |r| {
            format!(", {:.0} % as round as a circle", 100.0 * r.value)
        });
        let angle = quantity(rotation.value, rotation.sigma, "degrees");
        Some(format!(
            "{:.0} blades{shape}, one corner at {angle} from image x towards y",
            fitted.number("blades")
        ))
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        let &[blades, rotation_deg, reach, roundness] = values else {
            panic!("one value a parameter");
        };
        let blades = blades.round().min(MOST);
        if blades < FEWEST {
            return;
        }
        let half = std::f64::consts::PI / blades;
        let radius = reach / roundness.clamp(STRAIGHT, 1.0);
        let (half_side, apothem) = (reach * half.sin(), reach * half.cos());
        // Negative if the centre of the arc lies beyond the axis as seen from the blade.
        let off = apothem - (radius * radius - half_side * half_side).sqrt();
        pupil.set_rim_radius(reach * (1.0 + CLEARANCE));
        for blade in 0..blades as usize {
            let towards = rotation_deg.to_radians() + half * (2 * blade + 1) as f64;
            let (sin, cos) = towards.sin_cos();
            pupil.clip_iris(Stop {
                centre: [off * cos, off * sin],
                radius,
            });
        }
    }

    fn starts(&self) -> Vec<SearchStart> {
        let each = |roundness: f64, blades: usize| {
            // Two orientations, half of the symmetry angle apart.
            [0.0, 180.0 / blades as f64].map(|rotation| {
                let values = [blades as f64, rotation, 1.0, roundness];
                // A part of the way to them is another polygon, not a weaker one.
                SearchStart::new(&values, &[false, true, true, true]).likely()
            })
        };
        // A search from straight blades hardly reaches the corners of curved ones.
        let all = [0.2, 0.7].into_iter();
        all.flat_map(|roundness| (5..=9).flat_map(move |blades| each(roundness, blades)))
            .collect()
    }

    // The polygon closes with the pupil. The blades keep their curvature, so a smaller polygon has
    // straighter sides.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let mut all = values.to_vec();
        all[3] = values[3].scaled(ratios.pupil);
        all
    }
}

/// Returns initial irises of fits: blades, rotation of a corner, distance of the corners, roundness. Their discs are about as
/// large as round ones.
fn irises() -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    for blades in 5..=11 {
        let blades = f64::from(blades);
        let straight = (3.0 / (2.0 + (TAU / blades).cos())).sqrt();
        for roundness in [0.2, 0.7] {
            for quarter in 0..4 {
                let rotation = 90.0 / blades * f64::from(quarter);
                let reach = 1.0 + (1.0 - roundness) * (straight - 1.0);
                all.push(vec![blades, rotation, reach, roundness]);
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};
    use crate::field::Meridian;
    use std::f64::consts::PI;

    fn pupil(blades: f64, roundness: f64, alpha: f64) -> LocalPupil {
        let values = [blades, 17.0, 0.95, roundness];
        behind(&AperturePolygon, &values, place(0.4, 0.2), disc(alpha))
    }

    fn reach(pupil: &LocalPupil, degrees: f64) -> f64 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        pupil.edge([0.0, 0.0], cos, sin).0
    }

    fn area(pupil: &LocalPupil) -> f64 {
        let each = (0..7200).map(|k| reach(pupil, f64::from(k) / 20.0).powi(2));
        each.sum::<f64>() * PI / 7200.0
    }

    #[test]
    fn the_pupil_is_a_polygon_with_rotational_symmetry() {
        for blades in [3.0, 5.0, 6.0, 9.0, 13.0] {
            let pupil = pupil(blades, 0.0, 3.0);
            let want = 0.95 * 0.95 * blades / 2.0 * (TAU / blades).sin();
            let got = area(&pupil);
            assert!((got / want - 1.0).abs() < 2e-3, "{blades}: {got} {want}");
            for degrees in [17.0, 40.0, 111.0] {
                let (a, b) = (
                    reach(&pupil, degrees),
                    reach(&pupil, degrees + 360.0 / blades),
                );
                assert!((a - b).abs() < 1e-9, "{blades}: {a} {b}");
            }
            assert!((reach(&pupil, 17.0) - 0.95).abs() < 1e-6);
            let side = reach(&pupil, 17.0 + 180.0 / blades);
            assert!((side - 0.95 * (PI / blades).cos()).abs() < 2e-3);
        }
    }

    #[test]
    fn moments_are_those_of_a_polygon() {
        for blades in [3.0, 5.0, 6.0, 7.0, 8.0, 9.0, 13.0] {
            let (moments, centroid) = pupil(blades, 0.0, 1.0).moments();
            let want = 0.95 * 0.95 * (2.0 + (TAU / blades).cos()) / 12.0;
            // Straight blades are arcs: those of a triangle bulge by a thousandth.
            for got in [moments.mu20, moments.mu02] {
                assert!((got / want - 1.0).abs() < 2e-3, "{blades}: {got} {want}");
            }
            assert!(
                centroid[0].hypot(centroid[1]) < 2e-4,
                "{blades}: {centroid:?}"
            );
        }
    }

    #[test]
    fn round_blades_make_a_disc() {
        let (moments, _) = pupil(7.0, 1.0, 4.0).moments();
        let want = (0.95_f64 * 4.0).powi(2) / 4.0;
        assert!((moments.mu20 - want).abs() < 1e-9 && moments.mu11.abs() < 1e-9);
        let [straight, bent, disc] = [0.0, 0.5, 1.0].map(|r| area(&pupil(7.0, r, 4.0)));
        assert!(straight < bent && bent < disc);
    }

    #[test]
    fn a_triangle_is_mirrored_through_focus() {
        let third = |alpha| {
            let (moments, _) = pupil(3.0, 0.0, alpha).moments();
            let (sin, cos) = 17.0_f64.to_radians().sin_cos();
            moments.rotated_into(Meridian { cos, sin }).mu30
        };
        let (behind, before) = (third(3.0), third(-3.0));
        assert!(behind > 0.1, "a corner lies along the direction: {behind}");
        assert!((behind + before).abs() < 1e-9);
    }

    #[test]
    fn five_corners_point_the_other_way_on_the_other_side_of_focus() {
        // The farthest landing point towards the corner, or away from it.
        let furthest = |alpha: f64, sign: f64| {
            let pupil = pupil(5.0, 0.0, alpha);
            let (sin, cos) = 17.0_f64.to_radians().sin_cos();
            let landed = (0..720).map(|k| {
                let degrees = 17.0 + f64::from(k) / 2.0;
                let (s, c) = degrees.to_radians().sin_cos();
                let r = reach(&pupil, degrees);
                let [x, y] = pupil.landing([r * c, r * s]);
                sign * (x * cos + y * sin)
            });
            landed.fold(f64::NEG_INFINITY, f64::max)
        };
        let (corner, side) = (0.95 * 3.0, 0.95 * 3.0 * (PI / 5.0).cos());
        for (alpha, towards, away) in [(3.0, corner, side), (-3.0, side, corner)] {
            assert!((furthest(alpha, 1.0) - towards).abs() < 1e-2);
            assert!((furthest(alpha, -1.0) - away).abs() < 1e-2);
        }
    }

    #[test]
    fn fewer_than_three_blades_are_round_and_closing_straightens_blades() {
        assert_eq!(pupil(2.0, 0.0, 3.0), disc(3.0));
        let values = [7.0, 10.0, 1.0, 0.4].map(VergenceSeries::constant);
        let ratios = ControlRatios {
            pupil: 0.5,
            image_distance: 1.1,
        };
        let closed = AperturePolygon.rescale(&values, ratios);
        assert_eq!(closed[..3], values[..3]);
        assert_eq!(closed[3].at(0.0), 0.2);
    }

    #[test]
    fn most_blades_and_vignetting_fit() {
        let mut pupil = pupil(MOST, 0.0, 3.0);
        for _ in 0..3 {
            let circles = [0.9, 0.4, 0.9, -0.4];
            pupil = behind(
                &crate::effects::Vignetting,
                &circles,
                place(0.9, 0.5),
                pupil,
            );
        }
        assert_eq!(pupil.stops().len(), MAX_STOPS);
        assert!(pupil.inscribed_circle().1 > 0.0);
    }
}
