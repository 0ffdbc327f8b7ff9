//! Focus picking: the object distance at a pixel of the depth image.

use seidel_core::ObjectDistance;

use crate::guard::guard;
use crate::handles;
use crate::handles::SeidelLens;
use crate::plate::{Plate, SeidelPlate};
use crate::pointers::OutputPointer;
use crate::settings::{SeidelSettings, Settings};
use crate::status::{Failure, SeidelStatus};

/// Writes to `*distance` the object distance at the pixel (`x`, `y`) of the plate, in metres along the optical axis: the
/// median of the depth image over a disc of 3 pixels' radius, so that noise and fine gaps do not count. It may be INFINITY. As
/// `focus_distance` of the settings it focuses on what the pixel shows, as the option --focus-at of the command does.
/// `settings` may be NULL for the defaults.
///
/// Errors: a pixel outside the extent, a plate without distance there, and those of seidel_apply about the depth image.
///
/// # Safety
/// Each pointer: NULL, or valid until the call returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn seidel_distance_at(
    lens: *const SeidelLens,
    settings: *const SeidelSettings,
    plate: *const SeidelPlate,
    x: i32,
    y: i32,
    distance: *mut f64,
) -> SeidelStatus {
    guard(|| {
        let lens = handles::lens(lens)?;
        // SAFETY: as the caller guarantees.
        let output = unsafe { OutputPointer::new(distance, "distance")? };
        // SAFETY: as the caller guarantees.
        let settings = unsafe { Settings::new(settings)? };
        // SAFETY: as the caller guarantees.
        let plate = unsafe { Plate::new(plate)? };
        let extent = plate.extent();
        let pixel = format!("pixel ({x}, {y})");
        let inside = |at: i32, first: i32, size: usize| {
            let offset = i64::from(at) - i64::from(first);
            usize::try_from(offset).ok().filter(|index| *index < size)
        };
        let column = inside(x, extent.left, extent.columns());
        let row = inside(y, extent.top, extent.height as usize);
        let (Some(column), Some(row)) = (column, row) else {
            let remedy = "give a pixel of plate.extent";
            return Err(Failure::argument(&pixel, "lies outside the plate", remedy));
        };
        let session = settings.session(&lens)?;
        let geometry = plate.layout().geometry(&settings);
        let depth = plate.depth(&session, &geometry, &settings)?;
        match depth.distance_at(column, row, extent.columns()) {
            ObjectDistance::Unknown => Err(Failure::argument(
                &pixel,
                "has no distance",
                "give plate.depth, or settings.distance",
            )),
            ObjectDistance::Infinity => {
                output.write(f64::INFINITY);
                Ok(())
            }
            ObjectDistance::Metres(metres) => {
                output.write(metres);
                Ok(())
            }
        }
    })
}
