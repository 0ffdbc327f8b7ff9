//! Memory that a call needs, and the caller's limit on it.

use seidel_core::{apply_bytes, layered_apply_bytes, remove_bytes};

use crate::guard::guard;
use crate::plate::{Plate, PlateLayout, SeidelPlate, plane_count};
use crate::pointers::OutputPointer;
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, Result, SeidelStatus};

/// Writes to `*bytes` the most memory that a call takes for a plate, in bytes, beside the caller's own images: with
/// `removal` 0 for seidel_apply, with 1 for seidel_remove, seidel_relens and seidel_check_lens. Of the plate,
/// `extent`, the channels of `source` and whether there is a `depth` matter; `source` may be NULL, which counts as 4 channels.
/// `settings` may be NULL for the defaults.
///
/// # Safety
/// Each pointer: NULL, or valid until the call returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_memory_needed(
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    removal: u32,
    bytes: *mut u64,
) -> SeidelStatus {
    guard(|| {
        // SAFETY: as the caller guarantees.
        let output = unsafe { OutputPointer::new(bytes, "bytes")? };
        // SAFETY: as the caller guarantees.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller guarantees.
        let layout = unsafe { PlateLayout::new(plate)? };
        let planes = plane_count(layout.channels.unwrap_or(4), &settings) as u64;
        let pixels = layout.extent.pixels() as u64;
        output.write(match removal {
            0 => apply_bytes_of(&layout, &settings)(pixels, planes),
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

/// Checks that blurring a plate stays within the memory limit of the settings.
pub(crate) fn check_apply_memory(plate: &Plate, settings: &Settings) -> Result<()> {
    check(apply_bytes_of(plate.layout(), settings), plate, settings)
}

/// Returns the memory that blurring a plate of `layout` takes by pixels and planes: more where near surfaces hide far ones.
fn apply_bytes_of(layout: &PlateLayout, settings: &Settings) -> fn(u64, u64) -> u64 {
    if layout.has_depth && settings.raw.occlusion == 1 {
        layered_apply_bytes
    } else {
        apply_bytes
    }
}

/// Checks that removing blur from a plate stays within the memory limit of the settings.
pub(crate) fn check_removal_memory(plate: &Plate, settings: &Settings) -> Result<()> {
    check(remove_bytes, plate, settings)
}

fn check(bytes: fn(u64, u64) -> u64, plate: &Plate, settings: &Settings) -> Result<()> {
    let planes = plane_count(plate.source.channels, settings) as u64;
    let needed = bytes(plate.extent().pixels() as u64, planes);
    let limit = settings.raw.memory;
    if limit == 0 || needed <= limit {
        return Ok(());
    }
    Err(Failure::new(
        SeidelStatus::Memory,
        format!(
            "settings.memory: is {limit} bytes, but the call needs {needed}; allow more, or give a smaller extent"
        ),
    ))
}
