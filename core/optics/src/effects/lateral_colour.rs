//! Magnification differs by wavelength.

use super::{ControlRatios, Effect, Parameter, ScenePoint, Scope, SearchStart};
use crate::lens::{LocalPupil, VergenceSeries};

/// `lateral_colour`: the picture has another size in each channel.
///
/// Looks like channels shifted against each other along the meridian, nothing in the middle, most in the
/// corners; PSFs keep their shape. Mistaken for `axial_colour` and for coma that differs by channel,
/// both of which change shapes. Chief rays move by X (linear + cubic |X|²) px against the channel of
/// middle wavelength, X in half frame widths: transverse chromatic aberration (Born and Wolf, section
/// 4.7) and its change with field.
#[derive(Debug, Clone, Copy, Default)]
pub struct LateralColour;

static PARAMETERS: [Parameter; 2] = [
    Parameter::new(
        "linear",
        "px",
        "shift half a frame width off the axis, by magnification",
    )
    .within(-100.0, 100.0)
    .scope(Scope::Difference),
    Parameter::new(
        "cubic",
        "px",
        "shift half a frame width off the axis, by distortion",
    )
    .within(-100.0, 100.0)
    .scope(Scope::Difference),
];

impl Effect for LateralColour {
    fn id(&self) -> &'static str {
        "lateral_colour"
    }

    fn summary(&self) -> &'static str {
        "magnification differs by wavelength: channels are shifted radially against each other"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, _pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        let stretch = values[0] + values[1] * point.at.radius().powi(2);
        [stretch * point.at.x, stretch * point.at.y]
    }

    fn starts(&self) -> Vec<SearchStart> {
        vec![SearchStart::all_free(&[0.3, 0.0])]
    }

    // Angles of deviation: by the field angle X / Z2 to the power a, spread over Z2. The pupil has no part.
    fn rescale(&self, values: &[VergenceSeries], to: ControlRatios) -> Vec<VergenceSeries> {
        vec![
            values[0].clone(),
            values[1].scaled(to.image_distance.powi(-2)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn a_channel_is_shifted_along_the_meridian_and_keeps_its_shapes() {
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
