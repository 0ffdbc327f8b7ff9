//! The region of interest: the pixels of the source that a window of the result depends on.

use seidel_core::{LensSession, ObjectDistance};

use crate::guard::guard;
use crate::handles;
use crate::handles::SeidelLens;
use crate::image::SeidelRect;
use crate::plate::{PlateLayout, SeidelPlate};
use crate::pointers::OutputPointer;
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, Result, SeidelStatus};

/// Writes to `*region` the pixels of the source that seidel_apply needs for a bit-identical result in `window`. With
/// SEIDEL_QUALITY_EXACT, edges that are not SEIDEL_EDGES_AUTO, one distance and a PSF model that needs no rays, these are `window` and the reach of the
/// kernels about it. Otherwise they are the whole extent: the fast renderer chooses its highlights, and occlusion its
/// depth layers, from the whole plate. seidel_remove, seidel_relens and seidel_check_lens always need the whole
/// extent. Of the plate, `format`, `extent` and the presence of `depth` matter. `settings` may be NULL for the
/// defaults.
///
/// Errors: those of seidel_apply.
///
/// # Safety
/// Each pointer: NULL, or valid until the call returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_region_of_interest(
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    window: *const SeidelRect,
    region: *mut SeidelRect,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        // SAFETY: as the caller guarantees.
        let output = unsafe { OutputPointer::new(region, "region")? };
        if window.is_null() {
            return Err(Failure::null("window"));
        }
        // SAFETY: the caller guarantees a rectangle.
        let window = unsafe { window.read_unaligned() };
        window.check("window")?;
        // SAFETY: as the caller guarantees.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller guarantees.
        let layout = unsafe { PlateLayout::new(plate)? };
        let session = settings.session(&lens)?;
        session.place(&layout.geometry(&settings))?;
        output.write(region_of_interest(&session, &settings, &layout, window)?);
        Ok(())
    })
}

fn region_of_interest(
    session: &LensSession,
    settings: &Settings,
    layout: &PlateLayout,
    window: SeidelRect,
) -> Result<SeidelRect> {
    let extent = layout.extent;
    if settings.raw.amount == 0.0 {
        return Ok(window.intersection(extent));
    }
    if !settings.is_exact()
        || settings.has_automatic_edges()
        || session.psf_model().needs_rays()
        || layout.has_depth
    {
        return Ok(extent);
    }
    let distance = if session.lens().predictor().depends_on_depth() {
        settings.distance()?
    } else {
        ObjectDistance::Unknown
    };
    let (x, y) = session.reach_px(&layout.geometry(settings), distance)?;
    // With a margin of its longer side any window in the extent covers it. The limit keeps sums within an `i32`.
    let max_margin = extent.width.max(extent.height);
    let margin = |px: f64| (px.ceil() as i32).min(max_margin);
    Ok(window.grown(margin(x), margin(y)).intersection(extent))
}
