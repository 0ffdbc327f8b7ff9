//! The blur of one lens replaced by that of another.

use std::sync::Arc;

use seidel_optics::error::Result;

use crate::image::Image;
use crate::lens::Lens;
use crate::plate::Plate;
use crate::prepared::PreparedPlate;
use crate::removed::{NoiseGain, RemovedPlate};
use crate::session::LensSession;
use crate::settings::Settings;
use seidel_optics::Progress;

/// Share of the work that is the removal.
const REMOVAL_SHARE: f64 = 0.9;

/// Removes the blur of lens `from`, with which `plate` was taken, and applies that of lens `to`; the plate keeps its grain.
/// The settings hold for both lenses.
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
    let from = Arc::new(LensSession::new(from, settings)?);
    let to = Arc::new(LensSession::new(to, settings)?);
    if from.is_neutral() {
        plate.image.check_sizes()?;
        plate.image.check_finite()?;
        return Ok(plate.image.clone());
    }
    let plate = from.prepare(plate.clone())?;
    let removed = plate.remove(NoiseGain::Skip, &|share| progress(REMOVAL_SHARE * share))?;
    let planes = apply_solution(&removed, &plate.seen_through(&to)?, progress)?;
    Ok(plate.to_image(planes))
}

fn apply_solution(
    removed: &RemovedPlate,
    other: &PreparedPlate,
    progress: &Progress,
) -> Result<Vec<Vec<f32>>> {
    removed.apply_other(other, &|share| {
        progress(REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share)
    })
}
