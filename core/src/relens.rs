//! The blur of one lens replaced by that of another.

use std::sync::Arc;

use seidel_optics::error::Result;

use crate::image::Image;
use crate::lens::Lens;
use crate::plane_removal::NoiseGain;
use crate::plate::Plate;
use crate::prepared::PreparedPlate;
use crate::session::LensSession;
use crate::settings::{RelensSide, Settings};
use seidel_optics::Progress;

/// Share of the work that is the removal.
const REMOVAL_SHARE: f64 = 0.9;

/// Removes the blur of lens `from`, with which `plate` was taken, and applies that of lens `to`; the plate keeps its grain.
/// The settings hold for both lenses, but look and bloom for `to` alone; [`Settings::from_controls`] and
/// [`Settings::to_controls`] replace the controls of one of them. The background of the plate is the clean plate through
/// `from`, as for [`remove`](crate::remove()).
///
/// ```
/// # fn main() -> seidel_core::Result<()> {
/// # let text = include_str!("../tests/data/lens.json");
/// use seidel_core::{Controls, Depth, Image, Lens, ObjectDistance, Plate, Settings};
/// use seidel_core::{no_progress, relens};
///
/// let wide_open = Lens::from_json(text)?;
/// let stopped_down = wide_open.with_controls(&Controls {
///     f_number: Some(2.0),
///     ..Controls::default()
/// })?;
/// let image = Image::from_interleaved(60, 40, 1, &[0.5; 60 * 40])?;
/// let plate = Plate::new(image).with_depth(Depth::Distance(ObjectDistance::metres(2.5)?));
/// let image = relens(&wide_open, &stopped_down, &plate, &Settings::default(), &no_progress)?;
/// assert!((image.colours[0][60 * 20 + 30] - 0.5).abs() < 0.01);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Settings that a lens cannot follow, a plate that is not valid, and cancellation by `progress`.
pub fn relens(
    from: &Lens,
    to: &Lens,
    plate: &Plate,
    settings: &Settings,
    progress: &Progress,
) -> Result<Image> {
    let session = |lens, side| LensSession::new(lens, &settings.of_side(side)).map(Arc::new);
    let (from, to) = (
        session(from, RelensSide::From)?,
        session(to, RelensSide::To)?,
    );
    if from.is_neutral() {
        return plate.image.checked_copy();
    }
    let plate = from.prepare(plate.clone())?;
    plate.relens(&plate.for_session(&to)?, progress)
}

impl PreparedPlate {
    /// Removes the blur of this plate's lens and applies that of `other`, the same plate prepared for another lens by
    /// [`PreparedPlate::for_session`]. The plate keeps its grain. It stays as it is if both lenses are the same.
    ///
    /// # Errors
    /// Those of [`PreparedPlate::remove`] and [`PreparedPlate::apply`].
    pub fn relens(&self, other: &Self, progress: &Progress) -> Result<Image> {
        if self.session().is_same_as(other.session()) {
            return self.to_image(self.planes().to_vec());
        }
        let removed = self.remove(NoiseGain::Skip, &|share| progress(REMOVAL_SHARE * share))?;
        let planes = removed.apply_other(self, other, &|share| {
            progress(REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share)
        })?;
        self.to_image(planes)
    }
}
