//! The picture of the aperture in the settings.

use seidel_core::AperturePicture;

use super::SeidelSettings;
use crate::pointers::read_array;
use crate::status::{Failure, Result};

/// Returns the picture of the aperture of `raw`, if it has one.
///
/// # Errors
/// A picture that is not whole rows, too large, black, or has a value that is not a number.
///
/// # Safety
/// `raw.aperture` must be NULL or point to `raw.aperture_count` values.
pub(super) unsafe fn aperture(raw: &SeidelSettings) -> Result<Option<AperturePicture>> {
    const MAX_SIDE: u64 = AperturePicture::MAX_SIDE as u64;
    if raw.aperture.is_null() && raw.aperture_count == 0 {
        return Ok(None);
    }
    // A wild count is refused before it is read.
    let (width, count) = (u64::from(raw.aperture_width), raw.aperture_count);
    if width == 0 || width > MAX_SIDE || count > width * MAX_SIDE || count % width != 0 {
        return Err(Failure::argument(
            "settings.aperture_count",
            format!("is {count} in rows of {width}"),
            &format!("give whole rows, and sides of 1 to {MAX_SIDE} pixels"),
        ));
    }
    // SAFETY: the caller guarantees as many values.
    let samples = unsafe { read_array(raw.aperture, count as usize, "settings.aperture")? };
    Ok(Some(AperturePicture::new(width as usize, &samples)?))
}
