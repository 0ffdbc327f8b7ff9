//! Replacing the blur of one lens by that of another.

use seidel_core::{Image, NoiseGain, PreparedPlate};

use crate::call_args::CallArgs;
use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::image::SeidelImage;
use crate::lens::SeidelLens;
use crate::memory::check_removal_memory;
use crate::plate::{HoldoutUse, SeidelPlate};
use crate::settings::SeidelSettings;
use crate::status::{Result, SeidelStatus};
use crate::threads::SharedProgress;

/// Share of the time that removal takes.
const REMOVAL_SHARE: f64 = 0.9;

/// Removes the blur of the lens `from` from a plate and applies that of `to`. The plate keeps its grain. The settings
/// hold for both lenses; `strength` and `grain` are not used. `output.rect` must lie in the extent. All else, errors
/// included, is as for seidel_remove.
///
/// # Safety
/// As for seidel_apply.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_relens(
    from: *const SeidelLens,
    to: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    output: *const SeidelImage,
    alphas: *const SeidelImage,
    callbacks: *const SeidelCallbacks,
) -> SeidelStatus {
    guard(|| {
        let (from, to) = (handles::lens(from)?, handles::lens(to)?);
        // SAFETY: as the caller guarantees.
        let args = unsafe { CallArgs::new(settings, plate, output, alphas, callbacks)? };
        let (plate, settings) = (&args.plate, &args.settings);
        plate.check_inside(&args.output)?;
        check_removal_memory(plate, settings)?;
        let image = if settings.raw.amount == 0.0 {
            plate.image(settings)?
        } else {
            let session = settings.session(&from)?;
            let prepared = plate.prepare(&session, settings, HoldoutUse::Ignore)?;
            let other = prepared.for_session(&settings.session(&to)?)?;
            args.run(move |progress| change_lens(&prepared, &other, progress))?
        };
        args.write(&image, plate.extent());
        Ok(())
    })
}

/// Removes the blur of the lens of `plate`, and applies that of `other`, the same plate prepared for another lens.
fn change_lens(
    plate: &PreparedPlate,
    other: &PreparedPlate,
    progress: &SharedProgress,
) -> Result<Image> {
    let removed = plate.remove(NoiseGain::Skip, &|share| {
        progress.report(REMOVAL_SHARE * share)
    })?;
    let planes = removed.apply_other(other, &|share| {
        progress.report(REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share)
    })?;
    Ok(plate.to_image(planes))
}
