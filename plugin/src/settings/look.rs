//! Look and bloom of the settings.

use seidel_core::{AperturePicture, Blades, Bloom, Look};

use super::{SEIDEL_BLADES_OF_LENS, SeidelSettings, Settings};
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

impl Settings {
    /// Puts look and bloom into `settings`.
    pub(super) fn put_look(&self, settings: &mut seidel_core::Settings) {
        let raw = &self.raw;
        settings.look = Look {
            blades: (raw.blades != SEIDEL_BLADES_OF_LENS).then_some(Blades {
                count: raw.blades,
                roundness: raw.roundness,
                rotation_deg: raw.rotation,
            }),
            picture: self.aperture.clone(),
            squeeze: raw.squeeze,
            obstruction: raw.obstruction,
            cats_eye: raw.cats_eye,
            spherical: raw.spherical,
            axial_colour: raw.axial_colour,
            lateral_colour: raw.lateral_colour,
        };
        settings.bloom = (raw.bloom != 0.0).then_some(Bloom {
            share: raw.bloom,
            level: raw.bloom_level,
            radius: raw.bloom_radius / 100.0,
        });
    }
}
