//! Axial colour: focus differs between channels.

use super::amount::joined;
use super::{
    ControlRatios, Description, Effect, Fitted, Parameter, ScenePoint, Scope, SearchStart,
};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

/// `axial_colour`: each channel is focused at another distance.
///
/// # Appearance
/// Colour fringes around defocused objects, one colour in front of focus and its complement behind, the same over the
/// whole field.
///
/// # Similar effects
/// `lateral_colour`, whose fringes turn with the meridian and vanish at the centre; spherical aberration that differs
/// between channels.
///
/// # Model
/// W gains `alpha` |u|²/2 px relative to the channel of middle wavelength: primary longitudinal chromatic aberration
/// (Born and Wolf, section 4.7).
#[derive(Debug, Clone, Copy, Default)]
pub struct AxialColour;

const PARAMETERS: [Parameter; 1] = [Parameter::new(
    "alpha",
    "px",
    "defocus relative to the channel of middle wavelength",
)
.within(-100.0, 100.0)
.scope(Scope::Difference)];

impl Effect for AxialColour {
    fn description(&self) -> &'static Description {
        &Description {
            id: "axial_colour",
            summary: "focus differs by wavelength: defocus differs by channel, the same over the field",
            title: "axial colour",
            meaning: "The colour channels focus at different distances.",
            action: "Use corrected.json, or fit the lens to PSFs of all channels. If it was right before, look for another light source or a filter in the beam.",
            parameters: &PARAMETERS,
            two_stops_down: "the difference in focus shrinks with the pupil",
            other_side_of_focus: "the colour order of the discs flips",
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let channels = fitted.by_channel("alpha").map(|(channel, alpha)| {
            match (fitted.lens.mm_per_px(), fitted.lens.side(-alpha.value)) {
                (Some(mm), Some(side)) => format!(
                    "channel {channel} focuses {} {side} the middle channel",
                    alpha.quantity(mm, "mm")
                ),
                _ => format!(
                    "channel {channel} is {} out of focus against the middle channel",
                    alpha.quantity(1.0, "px")
                ),
            }
        });
        joined(channels.collect())
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

    // R Z2 times the difference in power between channels.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        vec![values[0].scaled(ratios.pupil * ratios.image_distance)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn defocus_is_the_same_over_the_field() {
        assert_eq!(PARAMETERS[0].scope, Scope::Difference);
        for (x, y) in [(0.0, 0.0), (0.9, -0.3)] {
            let pupil = behind(&AxialColour, &[-0.75], place(x, y), disc(2.0));
            assert_eq!(pupil, disc(1.25));
            assert_eq!(AxialColour.chief_ray(&[-0.75], place(x, y)), [0.0; 2]);
        }
    }
}
