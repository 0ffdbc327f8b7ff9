//! Lens blur removed from a plate.

use std::sync::Arc;

use seidel_optics::error::Result;

use crate::image::Image;
use crate::lens::Lens;
use crate::plane_removal::NoiseGain;
use crate::plate::Plate;
use crate::session::LensSession;
use crate::settings::Settings;
use seidel_optics::Progress;

/// Removes the blur of the `lens` that `plate` was taken with; returns an image of the plate's size.
///
/// The depth of the plate is that of the sharp image. Its background, if it has one, is the clean plate through the same lens,
/// blur included: with it, the edges of the foreground become sharp, which keep their blur otherwise. Look and bloom of the
/// settings are not used. Clipped highlights that the lens does not explain keep their blur. See
/// [`PreparedPlate::remove`](crate::PreparedPlate::remove) for confidence, amplification of noise and overscan.
///
/// ```
/// # fn main() -> seidel_core::Result<()> {
/// # let text = include_str!("../tests/data/lens.json");
/// use seidel_core::{Depth, Image, Lens, ObjectDistance, Plate, Settings, no_progress, remove};
///
/// let lens = Lens::from_json(text)?;
/// let image = Image::from_interleaved(60, 40, 1, &[0.5; 60 * 40])?;
/// let plate = Plate::new(image).with_depth(Depth::Distance(ObjectDistance::metres(2.5)?));
/// let sharp = remove(&lens, &plate, &Settings::default(), &no_progress)?;
/// assert!((sharp.colours[0][60 * 20 + 30] - 0.5).abs() < 0.01);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Settings that the lens cannot follow, a plate that is not valid, and cancellation by `progress`.
pub fn remove(
    lens: &Lens,
    plate: &Plate,
    settings: &Settings,
    progress: &Progress,
) -> Result<Image> {
    let session = Arc::new(LensSession::new(lens, &settings.of_measured_lens())?);
    if session.is_neutral() || settings.removal.strength == 0.0 {
        return plate.image.checked_copy();
    }
    let plate = session.prepare(plate.clone())?;
    plate.remove(NoiseGain::Skip, progress)?.sharp_image(&plate)
}
