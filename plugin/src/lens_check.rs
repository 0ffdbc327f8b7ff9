//! Whether a plate shows the blur of its lens.

use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::lens::SeidelLens;
use crate::plate::{HoldoutUse, Plate, SeidelPlate};
use crate::pointers::{Place, Sized64, maybe_sized};
use crate::remove::check_bounds;
use crate::settings::{SeidelSettings, Settings};
use crate::status::SeidelStatus;
use crate::threads::{Watch, run};

/// Compares the blur that a plate shows with that of the lens it is said to be taken with: `blur_share` gets the plate's as
/// a share of the lens's, 1 where nothing speaks against the lens. What `seidel remove` does with it: below 1, settings.amount
/// is multiplied by it, since to remove more would ring; above 1, it is said. settings.amount must not be 0. `settings` and
/// `callbacks` may be NULL as in seidel_apply.
///
/// # Safety
/// That of seidel_apply; `blur_share` must be good for a number.
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
        // SAFETY: as the caller vouches, here and below.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as above.
        let plate = unsafe { Plate::new(plate)? };
        // SAFETY: as above.
        let callbacks = unsafe { maybe_sized(callbacks, "callbacks")? };
        // SAFETY: as above.
        let place = unsafe { Place::new(blur_share, "blur_share")? };
        check_bounds(&plate, &settings)?;
        if settings.raw.amount == 0.0 {
            return Err(crate::status::Failure::argument(
                "settings.amount",
                "is 0: the lens has no blur to compare",
                "give another",
            ));
        }
        let session = settings.session(&lens)?;
        let prepared = plate.prepare(&session, &settings, HoldoutUse::Ignore)?;
        let callbacks = callbacks.unwrap_or_else(SeidelCallbacks::neutral);
        let work = move |watch: &Watch| Ok(prepared.blur_share(&|share| watch.tell(share))?);
        place.put(run(settings.raw.threads, &callbacks, work)?);
        Ok(())
    })
}
