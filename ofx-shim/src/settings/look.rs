//! The knobs of the look as settings of the core.

use seidel_core::{AperturePicture, Blades, Bloom, Lens, Look, Settings};

use super::unless_zero;
use crate::host::{Failure, Result};
use crate::knobs::{Knobs, look};

/// Puts look and bloom for the lens `profile` into `settings`.
///
/// # Errors
/// A look of a lens that has no rays.
pub(crate) fn put_look(knobs: &Knobs, profile: &Lens, settings: &mut Settings) -> Result<()> {
    put_look_with(knobs, profile, None, settings)
}

/// Puts look and bloom into `settings` as [`put_look`], with a picture of the aperture.
///
/// # Errors
/// Those of [`put_look`].
pub(crate) fn put_look_with(
    knobs: &Knobs,
    profile: &Lens,
    picture: Option<AperturePicture>,
    settings: &mut Settings,
) -> Result<()> {
    let chosen = Look {
        blades: look::blade_count(knobs.choice(&look::BLADES)).map(|count| Blades {
            count,
            roundness: knobs.number(&look::ROUNDNESS),
            rotation_deg: knobs.number(&look::ROTATION),
        }),
        picture,
        squeeze: knobs.number(&look::SQUEEZE),
        obstruction: knobs.number(&look::OBSTRUCTION),
        cats_eye: knobs.number(&look::CATS_EYE),
        spherical: knobs.number(&look::SPHERICAL),
        axial_colour: knobs.number(&look::AXIAL_COLOUR),
        lateral_colour: knobs.number(&look::LATERAL_COLOUR),
    };
    if !(chosen.is_neutral() || profile.predictor().has_rays()) {
        return Err(Failure::failed(format!(
            "Look: {chosen}: this lens was fitted with --model moments, which says nothing about its pupil; set Blades to Lateral Colour to their defaults, or choose a lens that comes with Seidel or one fitted with --model reduced."
        )));
    }
    settings.look = chosen;
    settings.bloom = unless_zero(knobs.number(&look::BLOOM)).map(|share| Bloom {
        share,
        level: knobs.number(&look::BLOOM_LEVEL),
        radius: knobs.number(&look::BLOOM_RADIUS) / 100.0,
    });
    Ok(())
}
