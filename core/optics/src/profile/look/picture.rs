//! A picture of an aperture as an effect of a channel.

use crate::effects::{Description, Effect, Parameter, ScenePoint, Scope, SearchStart, Symmetry};
use crate::lens::{AperturePicture, LocalPupil, PictureMask};

/// Identifier of the effect. Profiles in files do not have it: they hold no picture.
pub(super) const ID: &str = "aperture_picture";

const PARAMETERS: [Parameter; 1] =
    [
        Parameter::new("turn", "1", "1 as the picture is, -1 turned by 180 degrees")
            .neutral_at(1.0)
            .within(-1.0, 1.0)
            .step(1.0)
            .scope(Scope::Channel),
    ];

impl Effect for AperturePicture {
    fn description(&self) -> &'static Description {
        &Description {
            id: ID,
            summary: "the aperture has a shape of its own: discs show it",
            parameters: &PARAMETERS,
            symmetry: Symmetry::None,
            is_cause: false,
            ..Description::DEFAULT
        }
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        let &[turn] = values else {
            panic!("one value a parameter");
        };
        pupil.transmission.picture = Some(PictureMask {
            picture: *self,
            scale: turn,
        });
    }

    fn starts(&self) -> Vec<SearchStart> {
        vec![SearchStart::new(&[1.0], &[false])]
    }
}
