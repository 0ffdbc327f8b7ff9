//! Sensor tilt.

use super::{
    ControlRatios, Description, Effect, FieldNeed, Fitted, Parameter, ScenePoint, SearchStart,
    Symmetry,
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
#[derive(Debug, Clone, Copy, Default)]
pub struct SensorTilt;

const PARAMETERS: [Parameter; 3] = [
    Parameter::new("tilt_x", "px/h", "change of defocus along x").within(-200.0, 200.0),
    Parameter::new("tilt_y", "px/h", "change of defocus along y").within(-200.0, 200.0),
    Parameter::new(
        "keystone",
        "1/h",
        "outward shift of chief rays per px of that defocus and half frame width off the axis",
    )
    .within(-50.0, 50.0)
    .step(0.1),
];

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
        let alpha = defocus(values, point);
        pupil.wavefront.add(1, 0, Meridian::X, alpha / 2.0);
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        let stretch = values[2] * defocus(values, point);
        [stretch * point.at.x, stretch * point.at.y]
    }

    fn starts(&self) -> Vec<SearchStart> {
        vec![
            SearchStart::all_free(&[0.5, 0.0, 0.0]),
            SearchStart::all_free(&[0.0, 0.5, 0.0]),
        ]
    }

    // Like `defocus_offset` at each field position: defocus scales with R / Z2 and the shift with 1 / Z2;
    // keystone is their ratio.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let cone = ratios.pupil / ratios.image_distance;
        vec![
            values[0].scaled(cone),
            values[1].scaled(cone),
            values[2].scaled(1.0 / ratios.pupil),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn defocus_is_linear_over_the_frame() {
        let values = [2.0, -3.0, 0.5];
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
