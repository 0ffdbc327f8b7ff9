//! What a part of a plate needs: of the source, and of memory.

use seidel_core::{LensSession, ObjectDistance, apply_bytes, remove_bytes};

use crate::guard::guard;
use crate::handles;
use crate::image::SeidelRect;
use crate::lens::SeidelLens;
use crate::plate::{Ground, SeidelPlate, plane_count};
use crate::pointers::Place;
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, Result, SeidelStatus};

/// Tells which pixels of the source seidel_apply must be given for its result in `window` to be that part of the whole
/// plate's to the bit. Of the plate, `format`, `extent` and whether there is a depth count. With SEIDEL_QUALITY_EXACT, one
/// distance and a model that needs no rays this is `window` and as much about it as kernels reach; otherwise the whole
/// extent: the fast renderer chooses its ways by all of the plate. seidel_remove and seidel_relens always need it all.
///
/// # Safety
/// All pointers must be NULL or good until the call ends.
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
        // SAFETY: as the caller vouches.
        let place = unsafe { Place::new(region, "region")? };
        if window.is_null() {
            return Err(Failure::argument("window", "is NULL", "give a pointer"));
        }
        // SAFETY: the caller vouches for a rectangle.
        let window = unsafe { window.read_unaligned() };
        window.check("window")?;
        // SAFETY: as the caller vouches.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller vouches.
        let ground = unsafe { Ground::new(plate)? };
        let session = settings.session(&lens)?;
        session.place(&ground.geometry(&settings))?;
        place.put(region_of(&session, &settings, &ground, window)?);
        Ok(())
    })
}

fn region_of(
    session: &LensSession,
    settings: &Settings,
    ground: &Ground,
    window: SeidelRect,
) -> Result<SeidelRect> {
    if settings.raw.amount == 0.0 {
        return Ok(window.meet(ground.extent));
    }
    if !settings.is_exact() || session.psf_model().needs_rays() || ground.has_depth {
        return Ok(ground.extent);
    }
    let distance = if session.lens().predictor().depends_on_depth() {
        settings.distance()?
    } else {
        ObjectDistance::Unknown
    };
    let (x, y) = session.reach_px(&ground.geometry(settings), distance)?;
    let most = ground.extent.width.max(ground.extent.height);
    let whole = |px: f64| (px.ceil() as i32).min(most);
    Ok(window.grown(whole(x), whole(y)).meet(ground.extent))
}

/// Tells how much memory seidel_apply (`removal` 0), or seidel_remove and seidel_relens (1) take at most for a plate, beside
/// the caller's own pictures, bytes. Of the plate, `extent` counts, and the channels of its source.
///
/// # Safety
/// All pointers must be NULL or good until the call ends.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_memory_needed(
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    removal: u32,
    bytes: *mut u64,
) -> SeidelStatus {
    guard(|| {
        // SAFETY: as the caller vouches.
        let place = unsafe { Place::new(bytes, "bytes")? };
        // SAFETY: as the caller vouches.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller vouches.
        let ground = unsafe { Ground::new(plate)? };
        let channels = ground.channels.unwrap_or(4) as usize;
        let planes = plane_count(channels, &settings) as u64;
        let pixels = ground.extent.pixels() as u64;
        place.put(match removal {
            0 => apply_bytes(pixels, planes),
            1 => remove_bytes(pixels, planes),
            other => {
                return Err(Failure::argument(
                    "removal",
                    format!("is {other}"),
                    "give 0 or 1",
                ));
            }
        });
        Ok(())
    })
}
