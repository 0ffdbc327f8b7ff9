//! Putting a lens's blur on a plate, or on a part of it.

use seidel_core::render::RenderWindow;
use seidel_core::{Image, PreparedPlate, apply_bytes};

use crate::call_args::CallArgs;
use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::image::{SeidelImage, SeidelRect, View};
use crate::lens::SeidelLens;
use crate::plate::{HoldoutUse, Plate, SeidelPlate, plane_count};
use crate::results::{check_memory, write_back};
use crate::settings::SeidelSettings;
use crate::status::{Failure, Result, SeidelStatus};
use crate::threads::{Watch, run};

/// Puts the blur of a lens on the pixels that `output.rect` names of a plate; it must lie in the plate's extent. `output`
/// may be the memory of the source. Where the source covers what seidel_region_of_interest names, the result is that part
/// of the whole plate's, to the bit. `settings` may be NULL for the defaults, `callbacks` NULL for none. `alphas` gets the
/// alpha of each colour where settings say `alpha_per_channel`; NULL otherwise.
///
/// # Safety
/// All pointers must be NULL or good until the call ends; outputs must not be used by other threads meanwhile.
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
        // SAFETY: as the caller vouches.
        let args = unsafe { CallArgs::new(settings, plate, output, alphas, callbacks)? };
        let CallArgs {
            settings,
            plate,
            output,
            alphas,
            callbacks,
        } = args;
        let window = window_of(&plate, output.rect, alphas.as_ref())?;
        let planes = plane_count(plate.source.channels, &settings) as u64;
        check_memory(apply_bytes(plate.extent.pixels() as u64, planes), &settings)?;
        let rect = output.rect;
        if settings.raw.amount == 0.0 {
            let image = plate.image(&settings)?;
            write_back(&image, plate.extent, &output, alphas.as_ref());
            return Ok(());
        }
        let session = settings.session(&lens)?;
        let prepared = plate.prepare(&session, &settings, HoldoutUse::Read)?;
        let work = move |watch: &Watch| blur(&prepared, window, watch);
        let image = run(settings.raw.threads, &callbacks, work)?;
        write_back(&image, rect, &output, alphas.as_ref());
        Ok(())
    })
}

fn blur(plate: &PreparedPlate, window: RenderWindow, watch: &Watch) -> Result<Image> {
    let planes = plate.apply_window(window, &|share| watch.tell(share))?;
    Ok(plate.to_image_of_size(window.width, window.height, planes))
}

/// The window of the extent that is asked for.
fn window_of(plate: &Plate, rect: SeidelRect, alphas: Option<&View>) -> Result<RenderWindow> {
    if !plate.extent.contains(rect) {
        return Err(Failure::argument(
            "output.rect",
            "is not all in plate.extent",
            "ask for pixels of the plate",
        ));
    }
    if alphas.is_some_and(|view| view.rect != rect) {
        return Err(Failure::argument(
            "alphas.rect",
            "is not that of output",
            "give pictures of the same pixels",
        ));
    }
    Ok(RenderWindow {
        column: (rect.left - plate.extent.left) as usize,
        row: (rect.top - plate.extent.top) as usize,
        width: rect.columns(),
        height: rect.height as usize,
    })
}
