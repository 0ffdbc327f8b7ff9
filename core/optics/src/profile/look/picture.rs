//! A picture of an aperture as an effect of a channel.

use crate::effects::{ControlRatios, Description, Effect, Parameter, ScenePoint, SearchStart};
use crate::lens::{AperturePicture, LocalPupil, PictureMask, VergenceSeries};

/// Identifier of the effect. Profiles in files do not have it: they hold no picture.
pub(super) const ID: &str = "aperture_picture";

static PARAMETERS: [Parameter; 1] = [Parameter {
    name: "turn",
    unit: "1",
    meaning: "1 as the picture is, -1 turned by 180 degrees",
    neutral: 1.0,
    least: -1.0,
    most: 1.0,
    step: 1.0,
    scope: crate::effects::Scope::Channel,
}];

impl Effect for AperturePicture {
    fn description(&self) -> &'static Description {
        &Description {
            id: ID,
            summary: "the aperture has a shape of its own: discs show it",
            is_cause: false,
            ..Description::DEFAULT
        }
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
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

    // The aperture closes with the pupil.
    fn rescale(&self, values: &[VergenceSeries], _ratios: ControlRatios) -> Vec<VergenceSeries> {
        values.to_vec()
    }
}
