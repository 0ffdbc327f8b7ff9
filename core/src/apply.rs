//! Lens blur applied to a plate.

use std::sync::Arc;

use seidel_optics::error::Result;

use crate::image::Image;
use crate::lens::Lens;
use crate::plate::Plate;
use crate::session::LensSession;
use crate::settings::Settings;
use seidel_optics::Progress;

/// Applies the blur of `lens` to `plate`; returns an image of the plate's size.
///
/// Each colour is blurred by the lens channel of its name. A lens with one channel blurs all colours alike, and a plate
/// with the one colour Y gets the mean of all lens channels.
///
/// ```
/// # fn main() -> seidel_core::Result<()> {
/// # let text = include_str!("../tests/data/lens.json");
/// use seidel_core::{Depth, Image, Lens, ObjectDistance, Plate, Settings, apply, no_progress};
///
/// let lens = Lens::from_json(text)?;
/// let white = Image::from_interleaved(60, 40, 3, &[1.0; 60 * 40 * 3])?;
/// let plate = Plate::new(white).with_depth(Depth::Distance(ObjectDistance::metres(2.5)?));
/// let mut settings = Settings::default();
/// settings.amount = 0.5;
/// let blurred = apply(&lens, &plate, &settings, &no_progress)?;
/// assert!((blurred.colours[0][60 * 20 + 30] - 1.0).abs() < 1e-3);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Settings that the lens cannot follow, a colour for which it has no channel, a plate that is not valid, and cancellation by
/// `progress`.
pub fn apply(
    lens: &Lens,
    plate: &Plate,
    settings: &Settings,
    progress: &Progress,
) -> Result<Image> {
    let session = Arc::new(LensSession::new(lens, settings)?);
    if session.is_neutral() {
        return plate.image.checked_copy();
    }
    let plate = session.prepare(plate.clone())?;
    plate.to_image(plate.apply(progress)?)
}
