//! A plate taken with one lens as another would have drawn it.

use seidel_core::{Image, NoiseGain, PreparedPlate};

use crate::call_args::CallArgs;
use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::image::SeidelImage;
use crate::lens::SeidelLens;
use crate::plate::{HoldoutUse, SeidelPlate};
use crate::remove::check_bounds;
use crate::results::write_back;
use crate::settings::SeidelSettings;
use crate::status::{Failure, Result, SeidelStatus};
use crate::threads::{Watch, run};

/// Share of the work that is the removal.
const REMOVAL_SHARE: f64 = 0.9;

/// Takes the blur of the lens `from` off a plate and puts that of `to` on; the plate keeps its grain. Settings hold for
/// both lenses. All else is as in seidel_remove, but that `output.rect` must lie in the extent.
///
/// # Safety
/// That of seidel_apply.
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
        // SAFETY: as the caller vouches.
        let args = unsafe { CallArgs::new(settings, plate, output, alphas, callbacks)? };
        let CallArgs {
            settings,
            plate,
            output,
            alphas,
            callbacks,
        } = args;
        if !plate.extent.contains(output.rect) {
            return Err(Failure::argument(
                "output.rect",
                "is not all in plate.extent",
                "ask for pixels of the plate",
            ));
        }
        check_bounds(&plate, &settings)?;
        let image = if settings.raw.amount == 0.0 {
            plate.image(&settings)?
        } else {
            let session = settings.session(&from)?;
            let prepared = plate.prepare(&session, &settings, HoldoutUse::Ignore)?;
            let other = prepared.for_session(&settings.session(&to)?)?;
            let work = move |watch: &Watch| change_lens(&prepared, &other, watch);
            run(settings.raw.threads, &callbacks, work)?
        };
        write_back(&image, plate.extent, &output, alphas.as_ref());
        Ok(())
    })
}

fn change_lens(plate: &PreparedPlate, other: &PreparedPlate, watch: &Watch) -> Result<Image> {
    let removed = plate.remove(NoiseGain::Skip, &|share| watch.tell(REMOVAL_SHARE * share))?;
    let planes = removed.apply_other(other, &|share| {
        watch.tell(REMOVAL_SHARE + (1.0 - REMOVAL_SHARE) * share)
    })?;
    Ok(plate.to_image(planes))
}
