//! Sensor tilt.

use super::{
    ControlRatios, Description, Effect, FieldNeed, FitPart, Fitted, Parameter, ScenePoint,
    SearchStart, Symmetry,
};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

/// `sensor_tilt`: defocus changes linearly across the frame.
///
/// # Appearance
/// One side of the frame is focused nearer than the other; the centre does not change.
///
/// # Similar effects
/// `decentre`, which tilts the field but adds coma; field curvature, if only one corner is compared.
///
/// # Model
/// alpha gains tilt . X px, with X in half frame widths: Scheimpflug geometry for small angles. Light that lands behind
/// the untilted plane has travelled farther from the axis: by `keystone` (tilt . X) X px.
///
/// Within a disc too one side lands farther behind than the other. To first order in the tilt, a disc of radius alpha px then has
/// the coma W = 3/8 `slant` alpha |u|² (tilt . u), but for a shift; `slant` is one over half the frame width in px.
#[derive(Debug, Clone, Copy, Default)]
pub struct SensorTilt;

const PARAMETERS: [Parameter; 4] = [
    Parameter::new("tilt_x", "px/h", "change of defocus along x").within(-200.0, 200.0),
    Parameter::new("tilt_y", "px/h", "change of defocus along y").within(-200.0, 200.0),
    Parameter::new(
        "keystone",
        "1/h",
        "outward shift of chief rays per px of that defocus and half frame width off the axis",
    )
    .within(-50.0, 50.0)
    .step(0.1),
    Parameter::new(
        "slant",
        "1/px",
        "change of defocus within a disc, per px of its radius and of the tilt",
    )
    .within(-0.02, 0.02)
    .step(1e-4),
];

/// The parameters that searches change: a gap does not tell `slant`.
const FREE: [bool; 4] = [true, true, true, false];

fn defocus(values: &[f64], point: ScenePoint) -> f64 {
    values[0] * point.at.x + values[1] * point.at.y
}

impl Effect for SensorTilt {
    fn description(&self) -> &'static Description {
        &Description {
            id: "sensor_tilt",
            summary: "the sensor is not square to the axis: defocus changes linearly across the frame",
            title: "a tilted sensor",
            meaning: "The sensor, or the lens on its mount, is not square to the optical axis: one side of the frame focuses nearer than the other.",
            action: "Clean and tighten mount and adapter, and have the sensor or the mount shimmed. If all PSFs are of one flat chart, first make sure that the chart itself was parallel to the sensor.",
            parameters: &PARAMETERS,
            symmetry: Symmetry::None,
            field_need: FieldNeed::Sides,
            two_stops_down: Description::SHRINKS,
            other_side_of_focus: "the side that is in focus changes",
            fit: FitPart {
                used: 4,
                // The cone is narrower for near objects, whose image lies farther behind the pupil.
                linear: 2,
                // Tiles do not show keystone.
                fixed: &[2],
                shared: true,
                starts: || vec![vec![0.0; 4]],
                worth: 0.05,
                ..FitPart::NONE
            },
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let tilt = fitted.vector("tilt_x", "tilt_y")?;
        // px of defocus a half frame width are this length along the axis over one across, for small angles.
        let angle = fitted.lens.cone.map(|cone| {
            let tangent = 2.0 * cone / fitted.lens.half_width_px;
            tilt.quantity(tangent.to_degrees(), "degrees")
        });
        Some(match (angle, fitted.lens.sign()) {
            (Some(angle), Some(sign)) => format!(
                "the sensor is tilted by {angle}, its far side towards {} of the picture",
                tilt.direction(sign)
            ),
            (Some(angle), None) => format!("the sensor is tilted by {angle}"),
            _ => format!(
                "defocus changes by {} from the middle to the side of the frame, towards {}",
                tilt.quantity(1.0, "px"),
                tilt.direction(1.0)
            ),
        })
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
        let wave = &mut pupil.wavefront;
        wave.add(1, 0, Meridian::X, defocus(values, point) / 2.0);
        let [along_x, _, along_y] = wave.hessian([0.0; 2]);
        let slant = 3.0 / 8.0 * values[3] * (along_x + along_y) / 2.0;
        let [x, y] = [0, 1].map(|k| slant * values[k]);
        wave.add_monomial(3, 0, x);
        wave.add_monomial(1, 2, x);
        wave.add_monomial(2, 1, y);
        wave.add_monomial(0, 3, y);
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        let stretch = values[2] * defocus(values, point);
        [stretch * point.at.x, stretch * point.at.y]
    }

    fn starts(&self) -> Vec<SearchStart> {
        vec![
            SearchStart::new(&[0.5, 0.0, 0.0, 0.0], &FREE),
            SearchStart::new(&[0.0, 0.5, 0.0, 0.0], &FREE),
        ]
    }

    // Like `defocus_offset` at each field position: defocus scales with R / Z2 and the shift with 1 / Z2;
    // keystone is their ratio. `slant` is of the frame.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let cone = ratios.pupil / ratios.image_distance;
        vec![
            values[0].scaled(cone),
            values[1].scaled(cone),
            values[2].scaled(1.0 / ratios.pupil),
            values[3].clone(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn a_slanted_disc_is_that_of_rays_on_a_tilted_plane() {
        let (tilt, slant) = ([0.0, 40.0], 1e-3);
        let pupil = behind(
            &SensorTilt,
            &[tilt[0], tilt[1], 0.0, slant],
            place(0.0, 0.0),
            disc(20.0),
        );
        let (moments, _) = pupil.moments();
        // Where the rays of a cone meet a plane on which defocus grows by the tilt over 1 / slant px.
        let steps = 400;
        let coordinate = |k: i32| (f64::from(k) + 0.5) * 2.0 / f64::from(steps) - 1.0;
        let rays = (0..steps).flat_map(|i| (0..steps).map(move |j| [coordinate(i), coordinate(j)]));
        let landings: Vec<f64> = rays
            .filter(|[x, y]| x.hypot(*y) <= 1.0)
            .map(|[_, y]| 20.0 * y / (1.0 - tilt[1] * slant * y))
            .collect();
        let mean_of = |f: &dyn Fn(f64) -> f64| {
            landings.iter().map(|y| f(*y)).sum::<f64>() / landings.len() as f64
        };
        let centre = mean_of(&|y| y);
        let third = mean_of(&|y| (y - centre).powi(3));
        assert!(
            (moments.mu03 / third - 1.0).abs() < 0.02,
            "{} {third}",
            moments.mu03
        );
        let none = behind(
            &SensorTilt,
            &[0.0, 40.0, 0.0, 0.0],
            place(0.0, 0.0),
            disc(20.0),
        );
        assert!(none.moments().0.mu03.abs() < 0.01 * third);
    }

    #[test]
    fn defocus_is_linear_over_the_frame() {
        let values = [2.0, -3.0, 0.5, 0.0];
        let alpha =
            |x, y| behind(&SensorTilt, &values, place(x, y), disc(1.0)).landing([1.0, 0.0])[0];
        assert_eq!(alpha(0.0, 0.0), 1.0);
        // Along the axis of the tilt nothing changes.
        assert!((alpha(0.6, 0.4) - 1.0).abs() < 1e-12);
        for (x, y) in [(0.5, 0.0), (-0.3, 0.6)] {
            let (near, far) = (alpha(x, y) - 1.0, alpha(2.0 * x, 2.0 * y) - 1.0);
            assert!((far - 2.0 * near).abs() < 1e-12);
            assert!((alpha(-x, -y) - 1.0 + near).abs() < 1e-12);
            let chief = SensorTilt.chief_ray(&values, place(x, y));
            assert!((chief[0] - 0.5 * near * x).abs() < 1e-12);
            assert!((chief[1] - 0.5 * near * y).abs() < 1e-12);
        }
    }
}
