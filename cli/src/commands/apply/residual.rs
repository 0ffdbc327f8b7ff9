//! `--residual`: the difference between a plate and its re-blurred sharp image, added where the sharp image is unchanged.

use std::path::Path;

use seidel_core::{PreparedPlate, no_progress};
use seidel_render::remove::change_map;

use crate::commands::CommandError;
use crate::commands::plates::{LENS_METADATA, LoadedPlate};
use seidel_image_io::error::FileError;
use seidel_image_io::residual::Residual;

/// Opens the residual `file` of `loaded`, which is rendered with the settings `record`. Adds a warning to the plate if the
/// residual was made with other settings.
///
/// # Errors
/// A file that is not a residual, and one of another plate or data window.
pub(super) fn open(
    file: &Path,
    loaded: &mut LoadedPlate,
    record: &[(String, String)],
) -> Result<Residual, CommandError> {
    let residual = Residual::open(file, &loaded.prepared.names())?;
    let (stored, own) = (residual.windows.data, loaded.plate.data_window());
    if stored != own {
        return Err(FileError::new(
            file,
            "dataWindow",
            format!(
                "is {stored}, that of {} {own}",
                loaded.plate.path().display()
            ),
            "give the plate that seidel remove wrote with it, not cropped or resized",
        )
        .into());
    }
    // The values count, not their sources.
    let settings = residual.settings.iter();
    let changes: Vec<String> = settings
        .filter(|(name, _)| name != LENS_METADATA)
        .filter_map(|(name, before)| {
            let now = record.iter().find(|(own, _)| own == name);
            let now = now.map_or("not given", |(_, value)| value);
            (now != before).then(|| format!("{name} was {before}, is {now}"))
        })
        .collect();
    if !changes.is_empty() {
        loaded.warnings.push(format!(
            "residual {}: was made with other settings ({}), so the original plate is not restored exactly",
            file.display(),
            changes.join("; ")
        ));
    }
    Ok(residual)
}

/// Adds the residual to the `blurred` planes of `plate`, weighted by one minus the blurred change of the sharp image.
pub(super) fn add(
    residual: &Residual,
    plate: &PreparedPlate,
    blurred: &mut [Vec<f32>],
) -> seidel_core::Result<()> {
    let now: Vec<&[f32]> = plate.planes().iter().map(Vec::as_slice).collect();
    let before: Vec<&[f32]> = residual.sharp.iter().map(Vec::as_slice).collect();
    let change = change_map(&now, &before, &residual.noise)?;
    let blurred_change = if change.iter().any(|c| *c > 0.0) {
        plate.render_mask(&change, &no_progress)?
    } else {
        change
    };
    for (plane, residual) in blurred.iter_mut().zip(&residual.residual) {
        for ((sample, residual), change) in plane.iter_mut().zip(residual).zip(&blurred_change) {
            *sample += residual * (1.0 - change.clamp(0.0, 1.0));
        }
    }
    Ok(())
}
