//! The fault that the demo plants: on the day of the shot a matte box clips the oblique pencils of the lens.

use seidel_core::LensProfile;
use seidel_core::profile::{LensDescription, ProfileEffect};
use seidel_optics::effects::{Effect, Vignetting};
use seidel_optics::lens::VergenceSeries;

/// Radius of the matte box seen through the lens, pupil radii.
const RADIUS: f64 = 1.1;
/// Its shift with the field, pupil radii per half frame width.
const SHIFT: f64 = 0.5;

/// Returns `lens` behind a matte box: a circle that clips the pupil off the axis.
///
/// # Panics
/// If the lens is described by moments, which have no pupil to clip.
#[must_use]
pub fn behind_a_matte_box(lens: &LensProfile) -> LensProfile {
    let mut changed = lens.clone();
    let LensDescription::Pupil(channels) = &mut changed.description else {
        panic!("the built-in lens is modelled ray by ray");
    };
    let values = Vignetting.parameters().iter().map(|parameter| {
        VergenceSeries::constant(match parameter.name {
            "radius_1" => RADIUS,
            "shift_1" => SHIFT,
            _ => parameter.neutral,
        })
    });
    let values: Vec<VergenceSeries> = values.collect();
    for channel in channels {
        // As an effect after the fit: it moves the centroids too.
        channel.added.push(ProfileEffect {
            effect: &Vignetting,
            values: values.clone(),
        });
    }
    changed.provenance.settings = "designed, with a matte box planted".to_owned();
    changed
}
