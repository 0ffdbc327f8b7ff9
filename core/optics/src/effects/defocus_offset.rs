//! Constant defocus: an error of sensor position or focus.

use super::amount::quantity;
use super::{ControlRatios, Description, Effect, Fitted, Parameter, ScenePoint, SearchStart};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

/// `defocus_offset`: the same extra defocus at all field positions and distances.
///
/// # Appearance
/// Another focus distance. The sign shows in the change with depth, or where spherical aberration gives discs a bright
/// rim on one side of focus and a soft one on the other.
///
/// # Similar effects
/// `depth_scale`, if there is one object distance only; field curvature, if only corners are compared.
///
/// # Model
/// W gains `alpha` |u|²/2 (Hopkins's W020), with alpha the slope at the rim of the pupil in px. A shifted sensor also
/// changes the magnification: by `magnification` px half a frame width off the axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct DefocusOffset;

const PARAMETERS: [Parameter; 2] = [
    Parameter::new("alpha", "px", "defocus added at all field positions").within(-200.0, 200.0),
    Parameter::new(
        "magnification",
        "px",
        "outward shift of the chief ray half a frame width off the axis",
    )
    .within(-500.0, 500.0),
];

impl DefocusOffset {
    /// Index of the parameter that changes the size of the image.
    pub(super) const MAGNIFICATION: usize = 1;
}

impl Effect for DefocusOffset {
    fn description(&self) -> &'static Description {
        &Description {
            id: "defocus_offset",
            summary: "sensor or focus are not where the camera says: the same extra defocus everywhere",
            title: "a focus offset",
            meaning: "The sensor or the focus ring is not where the camera says: every point is out of focus by the same amount.",
            action: "Set the focus to the stated distance again and repeat one PSF. If the offset returns, have the flange distance (shims of the mount) adjusted, or render with corrected.json.",
            parameters: &PARAMETERS,
            two_stops_down: Description::SHRINKS,
            other_side_of_focus: Description::ADDS,
            second_distance: "the extra defocus is the same at both distances",
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let alpha = fitted.of("alpha")?;
        let sensor = match (fitted.lens.mm_per_px(), fitted.lens.side(alpha.value)) {
            (Some(mm), Some(side)) => {
                let length = alpha.quantity(mm, "mm");
                format!("the sensor sits {length} {side} the stated focus")
            }
            (Some(mm), None) => format!(
                "the sensor sits {} off the stated focus, on a side that one distance does not show",
                alpha.quantity(mm, "mm")
            ),
            _ => format!(
                "points in focus become discs of {} radius",
                alpha.quantity(1.0, "px")
            ),
        };
        let (Some(slope), Some(stated)) = (fitted.lens.slope_px_m, fitted.lens.focus_per_m) else {
            return Some(sensor);
        };
        Some(format!(
            "{sensor}: the paraxial focus is at {}, that of the profile at {}",
            metres(stated - alpha.value / slope),
            metres(stated)
        ))
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
        pupil.wavefront.add(1, 0, Meridian::X, values[0] / 2.0);
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        [values[1] * point.at.x, values[1] * point.at.y]
    }

    // Both sides of focus are equally likely.
    fn starts(&self) -> Vec<SearchStart> {
        vec![
            SearchStart::all_free(&[0.5, 0.0]),
            SearchStart::all_free(&[-0.5, 0.0]),
        ]
    }

    // The sensor is off by a fixed length s: it cuts a cone of slope R / Z2, and the image grows by s / Z2.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        vec![
            values[0].scaled(ratios.pupil / ratios.image_distance),
            values[1].scaled(1.0 / ratios.image_distance),
        ]
    }
}

/// Formats the distance of vergence `v`, 1/m.
pub(super) fn metres(v: f64) -> String {
    if v < -1e-3 {
        "beyond infinity".to_owned()
    } else if v < 1e-3 {
        "infinity".to_owned()
    } else {
        quantity(1.0 / v, 0.0, "m")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn defocus_is_constant_and_chief_rays_move_radially() {
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (-0.7, 0.4)] {
            let pupil = behind(&DefocusOffset, &[1.5, 4.0], place(x, y), disc(2.0));
            assert_eq!(pupil, disc(3.5));
            let chief = DefocusOffset.chief_ray(&[1.5, 4.0], place(x, y));
            assert_eq!(chief, [4.0 * x, 4.0 * y]);
        }
    }
}
