//! Lateral colour: magnification differs between channels.

use super::amount::{joined, outwards};
use super::{
    ControlRatios, Description, Effect, FieldNeed, Fitted, Parameter, ScenePoint, Scope,
    SearchStart,
};
use crate::lens::VergenceSeries;

/// `lateral_colour`: the image has another magnification in each channel.
///
/// # Appearance
/// Channels shifted against each other along the meridian: not at the centre, most in the corners. PSFs keep their shape.
///
/// # Similar effects
/// `axial_colour`, and coma that differs between channels; both change the shape of PSFs.
///
/// # Model
/// Chief rays move by X (`linear` + `cubic` |X|²) px relative to the channel of middle wavelength, with X in half frame
/// widths: transverse chromatic aberration (Born and Wolf, section 4.7) and its change with field.
#[derive(Debug, Clone, Copy, Default)]
pub struct LateralColour;

const PARAMETERS: [Parameter; 2] = [
    Parameter::new(
        "linear",
        "px",
        "shift half a frame width off the axis, linear in field",
    )
    .within(-100.0, 100.0)
    .scope(Scope::Difference),
    Parameter::new(
        "cubic",
        "px",
        "shift half a frame width off the axis, cubic in field",
    )
    .within(-100.0, 100.0)
    .scope(Scope::Difference),
];

impl Effect for LateralColour {
    fn description(&self) -> &'static Description {
        &Description {
            id: "lateral_colour",
            summary: "magnification differs by wavelength: channels are shifted radially against each other",
            title: "lateral colour",
            meaning: "The colour channels have different magnifications: they are shifted against each other towards the corners.",
            action: "Use corrected.json. First make sure that neither camera nor raw converter corrects chromatic aberration in one of the sets.",
            parameters: &PARAMETERS,
            field_need: FieldNeed::Radii,
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let linear = fitted.by_channel("linear");
        let channels = linear.map(|(channel, linear)| {
            let cubic = fitted.by_channel("cubic").find(|(c, _)| *c == channel);
            let shift = linear.value + cubic.map_or(0.0, |(_, v)| v.value);
            format!("channel {channel} {}", outwards(shift))
        });
        let channels = joined(channels.collect())?;
        Some(format!("at the side of the frame, {channels}"))
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        let stretch = values[0] + values[1] * point.at.radius().powi(2);
        [stretch * point.at.x, stretch * point.at.y]
    }

    fn starts(&self) -> Vec<SearchStart> {
        vec![SearchStart::all_free(&[0.3, 0.0])]
    }

    // Powers of the field angle X / Z2, times Z2; independent of the pupil.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        vec![
            values[0].clone(),
            values[1].scaled(ratios.image_distance.powi(-2)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn shifts_lie_along_the_meridian_and_shapes_stay() {
        assert!(PARAMETERS.iter().all(|p| p.scope == Scope::Difference));
        let shift = |values: [f64; 2], x, y| LateralColour.chief_ray(&values, place(x, y));
        assert_eq!(shift([1.0, 2.0], 0.0, 0.0), [0.0; 2]);
        assert_eq!(shift([1.0, 2.0], 1.0, 0.0), [3.0, 0.0]);
        assert_eq!(shift([1.0, 0.0], 0.0, -0.5), [0.0, -0.5]);
        assert_eq!(shift([0.0, 2.0], 0.0, -0.5), [0.0, -0.25]);
        let pupil = behind(&LateralColour, &[1.0, 2.0], place(0.7, 0.4), disc(2.0));
        assert_eq!(pupil, disc(2.0));
    }
}
