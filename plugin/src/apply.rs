//! Applying the blur of a lens to a plate, or to a part of it.

use seidel_core::{Image, PreparedPlate, Progress, RenderWindow};

use crate::call_args::CallArgs;
use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::handles::SeidelLens;
use crate::image::SeidelImage;
use crate::memory::check_apply_memory;
use crate::plate::{HoldoutUse, SeidelPlate};
use crate::settings::SeidelSettings;
use crate::status::{Failure, Result, SeidelStatus};

/// Applies the blur of a lens to a plate and writes the pixels of `output.rect`, which must lie in the extent of the
/// plate. `output` has as many channels as the source and may be the memory of the source. If the source covers
/// seidel_region_of_interest, the result is bit-identical to that part of a render of the whole plate. `alphas` gets
/// the alpha of each colour over `output.rect` if `alpha_per_channel` is set, and is NULL otherwise. `settings` may
/// be NULL for the defaults, `callbacks` NULL for none.
///
/// Errors: SEIDEL_STATUS_ARGUMENT for invalid arguments and settings, and for a sample that is not finite;
/// SEIDEL_STATUS_UNSUPPORTED for settings that the lens does not support; SEIDEL_STATUS_MEMORY;
/// SEIDEL_STATUS_ABORTED.
///
/// # Safety
/// Each pointer: NULL, or valid until the call returns. No other thread may use the outputs meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_apply(
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
        let window = render_window(&args)?;
        let (plate, settings) = (&args.plate, &args.settings);
        check_apply_memory(plate, settings)?;
        if settings.raw.amount == 0.0 {
            return args.write(&plate.image(settings)?, plate.extent());
        }
        let session = settings.session(&lens)?;
        let prepared = plate.prepare(&session, settings, HoldoutUse::Read)?;
        let image = args.run(move |progress| blur(&prepared, window, progress))?;
        args.write(&image, args.output.rect)
    })
}

fn blur(plate: &PreparedPlate, window: RenderWindow, progress: &Progress) -> Result<Image> {
    let planes = plate.apply_window(window, progress)?;
    Ok(plate.to_image_of_window(window, planes)?)
}

/// Returns the window of the data window that the outputs cover.
fn render_window(args: &CallArgs) -> Result<RenderWindow> {
    args.plate.check_inside(&args.output)?;
    let (extent, rect) = (args.plate.extent(), args.output.rect);
    if args.alphas.is_some_and(|view| view.rect != rect) {
        return Err(Failure::argument(
            "alphas.rect",
            "is not output.rect",
            "give images of the same pixels",
        ));
    }
    Ok(RenderWindow {
        column: (rect.left - extent.left) as usize,
        row: (rect.top - extent.top) as usize,
        width: rect.columns(),
        height: rect.height as usize,
    })
}
