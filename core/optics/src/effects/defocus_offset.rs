//! Constant defocus: an error of sensor position or focus.

use super::{ControlRatios, Effect, Parameter, ScenePoint, SearchStart};
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

static PARAMETERS: [Parameter; 2] = [
    Parameter::new("alpha", "px", "defocus added at all field positions").within(-200.0, 200.0),
    Parameter::new(
        "magnification",
        "px",
        "outward shift of the chief ray half a frame width off the axis",
    )
    .within(-500.0, 500.0),
];

impl Effect for DefocusOffset {
    fn id(&self) -> &'static str {
        "defocus_offset"
    }

    fn summary(&self) -> &'static str {
        "sensor or focus are not where the camera says: the same extra defocus everywhere"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
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
