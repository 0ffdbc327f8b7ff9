//! Comparing the blur of a plate with that of a lens.

use seidel_core::Progress;

use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::handles::SeidelLens;
use crate::memory::check_removal_memory;
use crate::plate::{HoldoutUse, Plate, SeidelPlate};
use crate::pointers::{OutputPointer, Versioned, read_optional};
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, SeidelStatus};
use crate::threads::run;

/// Writes to `*blur_share` the blur that a plate shows as a share of the blur of a lens: 1 if nothing speaks against
/// the lens. To do as `seidel remove` does, multiply `amount` by a share below 1 before the removal, since removing
/// too much blur causes ringing, and only warn about a share above 1. A plate of less than 96 pixels either way, or
/// without detail above its noise, gives 1. `settings` and `callbacks` may be NULL as for seidel_apply; `amount` must
/// not be 0.
///
/// Errors: those of seidel_remove.
///
/// # Safety
/// Each pointer: NULL, or valid until the call returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_check_lens(
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    blur_share: *mut f64,
    callbacks: *const SeidelCallbacks,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        // SAFETY: as the caller guarantees.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller guarantees.
        let plate = unsafe { Plate::new(plate)? };
        // SAFETY: as the caller guarantees.
        let callbacks = unsafe { read_optional(callbacks, "callbacks")? };
        // SAFETY: as the caller guarantees.
        let output = unsafe { OutputPointer::new(blur_share, "blur_share")? };
        check_removal_memory(&plate, &settings)?;
        if settings.raw.amount == 0.0 {
            return Err(Failure::argument(
                "settings.amount",
                "is 0, so that the lens has no blur to compare",
                "give a number above 0",
            ));
        }
        let session = settings.session_of_plate(&lens, plate.colour_count())?;
        let prepared = plate.prepare(&session, &settings, HoldoutUse::Ignore)?;
        let callbacks = callbacks.unwrap_or_else(SeidelCallbacks::defaults);
        let work = move |progress: &Progress<'_>| Ok(prepared.blur_share(progress)?);
        output.write(run(settings.raw.threads, &callbacks, work)?);
        Ok(())
    })
}
