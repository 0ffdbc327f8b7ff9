//! Lens blur removed from a plate.

use std::sync::Arc;

use seidel_optics::error::Result;

use crate::image::Image;
use crate::lens::Lens;
use crate::plate::Plate;
use crate::removed::NoiseGain;
use crate::session::LensSession;
use crate::settings::Settings;
use seidel_optics::Progress;

/// Removes the blur of the `lens` that `plate` was taken with; returns an image of the plate's size.
///
/// The depth of the plate is that of the sharp image. Clipped highlights keep their blur. See
/// [`PreparedPlate::remove`](crate::PreparedPlate::remove) for confidence, amplification of noise and overscan.
///
/// # Errors
/// Settings that the lens cannot follow, a plate that is not valid, and cancellation by `progress`.
pub fn remove(
    lens: &Lens,
    plate: &Plate,
    settings: &Settings,
    progress: &Progress,
) -> Result<Image> {
    let session = Arc::new(LensSession::new(lens, settings)?);
    if session.is_neutral() || settings.removal.strength == 0.0 {
        plate.image.check_sizes()?;
        plate.image.check_finite()?;
        return Ok(plate.image.clone());
    }
    let plate = session.prepare(plate.clone())?;
    plate.remove(NoiseGain::Skip, progress)?.sharp_image(&plate)
}
