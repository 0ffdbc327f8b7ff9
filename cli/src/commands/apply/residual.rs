//! `--residual`: what the plate had beside what its lens makes of the sharp picture, put back where that is as it was.

use std::path::Path;

use seidel_core::remove::changed;
use seidel_core::render::Plane;

use crate::commands::CommandError;
use crate::commands::plates::Light;
use seidel_image_io::error::FileError;
use seidel_image_io::plate::Plate;
use seidel_image_io::residual::Residual;

/// Opens the residual of `plate`, whose planes are `light` and which is seen by the settings `told`; remarks go to
/// `said`.
pub(super) fn open(
    file: &Path,
    (plate, light): (&Plate, &Light),
    told: &[(String, String)],
    said: &mut Vec<String>,
) -> Result<Residual, CommandError> {
    let residual = Residual::open(file, light.names())?;
    let (stored, own) = (residual.windows.data, plate.data_window());
    if stored != own {
        return Err(FileError::new(
            file,
            "dataWindow",
            format!("is {stored}, that of {} {own}", plate.path().display()),
            "give the plate that seidel remove wrote with it, not cropped or resized",
        )
        .into());
    }
    let other: Vec<String> = (residual.settings.iter())
        .filter_map(|(name, before)| {
            let now = told.iter().find(|(own, _)| own == name);
            let now = now.map_or("not given", |(_, value)| value);
            (now != before).then(|| format!("{name} was {before}, is {now}"))
        })
        .collect();
    if !other.is_empty() {
        said.push(format!(
            "residual {}: was made with other settings ({}): the plate does not come back as it was",
            file.display(),
            other.join("; ")
        ));
    }
    Ok(residual)
}

/// Adds the residual to the `blurred` planes of `light`, as far as the sharp picture is as it was. `blur` is what
/// blurs the light.
pub(super) fn add(
    residual: &Residual,
    (light, weights): (&Light, &[Vec<f64>]),
    blurred: &mut [Vec<f32>],
    blur: impl FnOnce(&[Plane]) -> seidel_core::Result<Vec<Vec<f32>>>,
) -> seidel_core::Result<()> {
    let now: Vec<&[f32]> = light.planes().iter().map(Vec::as_slice).collect();
    let before: Vec<&[f32]> = residual.sharp.iter().map(Vec::as_slice).collect();
    let change = changed(&now, &before, &residual.noise)?;
    let gone = match change.iter().any(|c| *c > 0.0) {
        false => change,
        true => {
            let weights = mean_weights(&weights[..light.colour_count()]);
            let plane = Plane {
                samples: &change,
                weights: &weights,
            };
            blur(&[plane])?.swap_remove(0)
        }
    };
    for (plane, rest) in blurred.iter_mut().zip(&residual.residual) {
        for ((sample, rest), gone) in plane.iter_mut().zip(rest).zip(&gone) {
            *sample += rest * (1.0 - gone.clamp(0.0, 1.0));
        }
    }
    Ok(())
}

/// What acts on all colours together.
fn mean_weights(colours: &[Vec<f64>]) -> Vec<f64> {
    let channels = colours.first().map_or(0, Vec::len);
    let count = colours.len() as f64;
    let mean = |k: usize| colours.iter().map(|w| w[k]).sum::<f64>() / count;
    (0..channels).map(mean).collect()
}
