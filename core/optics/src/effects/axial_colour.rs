//! Focus differs by wavelength.

use super::{ControlRatios, Effect, Parameter, ScenePoint, Scope, SearchStart};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

/// `axial_colour`: each channel is focused at another distance.
///
/// Looks like coloured fringes about what is out of focus, one colour in front of focus and its opposite
/// behind, the same all over the field. Mistaken for `lateral_colour`, whose fringes turn with the
/// meridian and are absent in the middle, and for spherical aberration that differs by channel. W gains
/// alpha |u|²/2 px against the channel of middle wavelength: primary longitudinal chromatic aberration
/// (Born and Wolf, section 4.7).
#[derive(Debug, Clone, Copy, Default)]
pub struct AxialColour;

static PARAMETERS: [Parameter; 1] = [Parameter::new(
    "alpha",
    "px",
    "defocus against the channel of middle wavelength",
)
.within(-100.0, 100.0)
.scope(Scope::Difference)];

impl Effect for AxialColour {
    fn id(&self) -> &'static str {
        "axial_colour"
    }

    fn summary(&self) -> &'static str {
        "focus differs by wavelength: defocus differs by channel, the same over the field"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
        pupil.wavefront.add(1, 0, Meridian::X, values[0] / 2.0);
    }

    fn starts(&self) -> Vec<SearchStart> {
        vec![
            SearchStart::all_free(&[0.3]),
            SearchStart::all_free(&[-0.3]),
        ]
    }

    // The defocus of a power of the glass that differs by channel: R Z2 times it.
    fn rescale(&self, values: &[VergenceSeries], to: ControlRatios) -> Vec<VergenceSeries> {
        vec![values[0].scaled(to.pupil * to.image_distance)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn a_channel_is_out_of_focus_all_over_the_field() {
        assert_eq!(PARAMETERS[0].scope, Scope::Difference);
        for (x, y) in [(0.0, 0.0), (0.9, -0.3)] {
            let pupil = behind(&AxialColour, &[-0.75], place(x, y), disc(2.0));
            assert_eq!(pupil, disc(1.25));
            assert_eq!(AxialColour.chief_ray(&[-0.75], place(x, y)), [0.0; 2]);
        }
    }
}
