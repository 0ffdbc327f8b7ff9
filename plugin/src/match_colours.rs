//! Colour fringes taken off a plate, without sharpening it.

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

/// Takes the lateral and axial colour of a lens off a plate of R, G and B, and sharpens nothing else: every colour gets the
/// blur, and the place, of the colour whose blur is of middle size. Alpha does not change. `grain` of the settings is not
/// used. `output.rect` must lie in the extent. All else, errors included, is as for seidel_remove.
///
/// # Safety
/// As for seidel_apply.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_match_colours(
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    output: *const SeidelImage,
    alphas: *const SeidelImage,
    callbacks: *const SeidelCallbacks,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        // SAFETY: as the caller guarantees.
        let args = unsafe { CallArgs::new(settings, plate, output, alphas, callbacks)? };
        let (plate, settings) = (&args.plate, &args.settings);
        plate.check_inside(&args.output)?;
        check_removal_memory(plate, settings)?;
        let image = if settings.raw.amount == 0.0 || settings.raw.strength == 0.0 {
            plate.image(settings)?
        } else {
            let session = settings.session_of_plate(&lens, plate.colour_count())?;
            let prepared = plate.prepare(&session, settings, HoldoutUse::Ignore)?;
            args.run(move |progress| {
                let planes = prepared.match_colours(progress)?;
                Ok(prepared.to_image(planes)?)
            })?
        };
        args.write(&image, plate.extent())?;
        Ok(())
    })
}
