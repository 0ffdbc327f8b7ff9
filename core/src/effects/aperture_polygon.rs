//! The iris has blades.

use super::{Effect, Parameter, Resetting, ScenePoint, Start};
use crate::lens::{LocalPupil, MOST_STOPS, Stop, VergenceSeries};

/// `aperture_polygon`: the pupil is a polygon of `blades` sides in place of a circle.
///
/// Discs out of focus are polygons of one shape all over the field, that turn with the iris and are
/// mirrored through their middle from one side of focus to the other; with an odd number of blades that
/// tells the sides apart. Mistaken for astigmatism and coma of higher order, and for `apodisation` where
/// corners are small. One corner points `rotation_deg` from image x towards y; corners lie `reach` pupil
/// radii from the axis; sides are arcs of curvature `roundness` / reach, straight at 0, one circle at 1.
/// The geometry of an iris; where the pupil is inverted the polygon is turned by half a turn.
#[derive(Debug, Clone, Copy, Default)]
pub struct AperturePolygon;

/// Fewest blades that bound anything, and the most that are tried for.
const FEWEST: f64 = 3.0;
const MOST: f64 = 13.0;
/// Curvature of blades that count as straight, per pupil radius.
const STRAIGHT: f64 = 1e-3;
/// The rim lies outside the corners by so much: light is bounded by the blades alone.
const CLEARANCE: f64 = 1e-6;

static PARAMETERS: [Parameter; 4] = [
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
    .at_rest(1.0)
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
    1 + 2 + 2 + MOST as usize <= MOST_STOPS,
    "rim, vignetting twice, blades"
);

impl Effect for AperturePolygon {
    fn id(&self) -> &'static str {
        "aperture_polygon"
    }

    fn summary(&self) -> &'static str {
        "the iris has blades: discs are polygons, mirrored through focus"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn act(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
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
        // Negative: beyond the axis, as seen from the blade.
        let off = apothem - (radius * radius - half_side * half_side).sqrt();
        pupil.bound(reach * (1.0 + CLEARANCE));
        for blade in 0..blades as usize {
            let towards = rotation_deg.to_radians() + half * (2 * blade + 1) as f64;
            let (sin, cos) = towards.sin_cos();
            pupil.clip(Stop {
                centre: [off * cos, off * sin],
                radius,
            });
        }
    }

    fn starts(&self) -> Vec<Start> {
        let each = |blades: usize| {
            // Two orientations, half the turn apart that makes a polygon the same again.
            [0.0, 180.0 / blades as f64].map(|rotation| Start {
                values: vec![blades as f64, rotation, 1.0, 0.2],
                free: vec![false, true, true, true],
            })
        };
        (5..=9).flat_map(each).collect()
    }

    // The polygon is the iris and closes with the pupil; its blades keep their own curvature, so that a
    // smaller one has straighter sides.
    fn reset(&self, values: &[VergenceSeries], to: Resetting) -> Vec<VergenceSeries> {
        let mut all = values.to_vec();
        all[3] = values[3].scaled(to.pupil);
        all
    }
}
