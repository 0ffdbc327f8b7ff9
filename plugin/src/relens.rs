//! Replacing the blur of one lens by that of another.

use seidel_core::{Lens, RelensSide};

use crate::call_args::CallArgs;
use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::handles::SeidelLens;
use crate::image::SeidelImage;
use crate::memory::check_removal_memory;
use crate::plate::{HoldoutUse, SeidelPlate};
use crate::settings::SeidelSettings;
use crate::status::SeidelStatus;

/// Removes the blur of the lens `from` from a plate and applies that of `to`. The plate keeps its grain. The settings
/// hold for both lenses, but `from_...` and `to_...` for one of them; `strength` and `grain` are not used. `output.rect` must lie in the extent. All else, errors
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
            let session =
                |lens: &Lens, side| settings.session_of_side(lens, side, plate.colour_count());
            let from = session(&from, RelensSide::From)?;
            let prepared = plate.prepare(&from, settings, HoldoutUse::Ignore)?;
            let other = prepared.for_session(&session(&to, RelensSide::To)?)?;
            args.run(move |progress| Ok(prepared.relens(&other, progress)?))?
        };
        args.write(&image, plate.extent())?;
        Ok(())
    })
}
