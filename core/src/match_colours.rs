//! Colour fringes taken off a plate, without sharpening it.

use std::sync::Arc;

use rayon::prelude::*;
use seidel_optics::Progress;
use seidel_optics::error::{Error, Result};
use seidel_render::remove::{find_lights, match_blur, reference_colour};

use crate::image::Image;
use crate::lens::Lens;
use crate::plate::Plate;
use crate::prepared::PreparedPlate;
use crate::removed::{RemovalInputs, deconvolver_of_plane};
use crate::session::LensSession;
use crate::settings::Settings;

/// Share of the progress taken by the search for lights.
const FINDING_SHARE: f64 = 0.6;

/// Takes the lateral and axial colour of `lens` off `plate`, and sharpens nothing else: every colour gets the blur, and the
/// place, of the colour whose blur is of middle size. Returns an image of the plate's size; alpha does not change.
///
/// ```
/// # fn main() -> seidel_core::Result<()> {
/// # let text = include_str!("../tests/data/lens.json");
/// use seidel_core::{Depth, Image, Lens, ObjectDistance, Plate, Settings, match_colours, no_progress};
///
/// let lens = Lens::from_json(text)?;
/// let image = Image::from_interleaved(60, 40, 3, &[0.5; 60 * 40 * 3])?;
/// let plate = Plate::new(image).with_depth(Depth::Distance(ObjectDistance::metres(2.5)?));
/// let clean = match_colours(&lens, &plate, &Settings::default(), &no_progress)?;
/// assert!((clean.colours[0][60 * 20 + 30] - 0.5).abs() < 0.01);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Settings that the lens cannot follow, a plate that is not valid or of one colour, and cancellation by `progress`.
pub fn match_colours(
    lens: &Lens,
    plate: &Plate,
    settings: &Settings,
    progress: &Progress,
) -> Result<Image> {
    let session = Arc::new(LensSession::new(lens, &settings.of_measured_lens())?);
    if session.is_neutral() || settings.removal.strength == 0.0 {
        return plate.image.checked_copy();
    }
    let plate = session.prepare(plate.clone())?;
    plate.to_image(plate.match_colours(progress)?)
}

impl PreparedPlate {
    /// Takes off colour fringes alone, as [`match_colours`] does, at the strength of the settings. Returns the premultiplied planes
    /// of the plate, as its sensor records them.
    ///
    /// # Errors
    /// A plate of one colour, those of [`seidel_render::remove::Deconvolver::remove`], cancellation by `progress` among
    /// them.
    pub fn match_colours(&self, progress: &Progress) -> Result<Vec<Vec<f32>>> {
        let RemovalInputs {
            light,
            settings,
            scale,
            ..
        } = self.removal_inputs()?;
        let colour_count = light.colour_count();
        if colour_count < 2 {
            let remedy = "give a plate with R, G and B, or remove all blur";
            return Err(Error::new("plate", "has one colour: no fringes", remedy));
        }
        let mut planes = self.with_optics(|optics| {
            let scene = &optics.scene;
            let planes = light.weighted(self.weights());
            let colours = &planes[..colour_count];
            let reference = reference_colour(scene, &self.weights()[..colour_count])?;
            let reference = colours[reference].weights;
            let own: Vec<_> = (colours.iter().enumerate())
                .map(|(index, plane)| {
                    (deconvolver_of_plane(&settings, index, colour_count), *plane)
                })
                .collect();
            let finding = |part: f64| progress(FINDING_SHARE * part);
            let lights = find_lights(scene, &own, &finding)?;
            let mut matched = light.planes().to_vec();
            for (index, plane) in colours.iter().enumerate() {
                let share = |part: f64| {
                    let done = (index as f64 + part) / colour_count as f64;
                    progress(FINDING_SHARE + (1.0 - FINDING_SHARE) * done)
                };
                matched[index] = match_blur(&lights[index], scene, plane, reference, &share)?;
            }
            Ok(matched)
        })?;
        if let Some(scale) = scale {
            let colours = planes.iter_mut().take(colour_count);
            colours.for_each(|plane| scale.restore(plane));
        }
        self.develop(&mut planes);
        let strength = settings.strength as f32;
        if strength < 1.0 {
            for (plane, before) in planes.iter_mut().zip(self.planes()) {
                let samples = plane.par_iter_mut().zip(before);
                samples.for_each(|(sample, before)| {
                    *sample = before + strength * (*sample - before);
                });
            }
        }
        Ok(planes)
    }
}
