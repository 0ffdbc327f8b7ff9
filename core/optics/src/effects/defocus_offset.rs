//! The sensor or the focus ring is not where the camera says.

use super::{ControlRatios, Effect, Parameter, ScenePoint, SearchStart};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

/// `defocus_offset`: the same extra defocus everywhere in the field and at every distance.
///
/// Looks like another focus distance: what was sharp is not, and another distance is. Its sign shows
/// against depth, or as discs with a bright rim where spherical aberration meets it one way and a soft
/// one the other. Mistaken for `depth_scale` where there is a single object distance, and for curvature
/// of field where only corners are looked at. With `alpha` in px of slope at the rim of the pupil
/// W gains alpha |u|²/2, Hopkins's W020; a sensor that moves also sees the picture larger, by
/// `magnification` px half a frame width off the axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct DefocusOffset;

static PARAMETERS: [Parameter; 2] = [
    Parameter::new("alpha", "px", "defocus added everywhere").within(-200.0, 200.0),
    Parameter::new(
        "magnification",
        "px",
        "how far a chief ray half a frame width off the axis moves outwards",
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

    // Through focus and back: which side is likelier is not known.
    fn starts(&self) -> Vec<SearchStart> {
        vec![
            SearchStart::all_free(&[0.5, 0.0]),
            SearchStart::all_free(&[-0.5, 0.0]),
        ]
    }

    // A sensor, or a focusing mount, off by a fixed length s: the cone that it cuts has the slope R / Z2,
    // and the picture grows by s / Z2.
    fn rescale(&self, values: &[VergenceSeries], to: ControlRatios) -> Vec<VergenceSeries> {
        vec![
            values[0].scaled(to.pupil / to.image_distance),
            values[1].scaled(1.0 / to.image_distance),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn every_place_gets_the_same_defocus_and_chief_rays_move_radially() {
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (-0.7, 0.4)] {
            let pupil = behind(&DefocusOffset, &[1.5, 4.0], place(x, y), disc(2.0));
            assert_eq!(pupil, disc(3.5));
            let chief = DefocusOffset.chief_ray(&[1.5, 4.0], place(x, y));
            assert_eq!(chief, [4.0 * x, 4.0 * y]);
        }
    }
}
