//! A fitted lens.

use seidel_optics::BlurField;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::field::ImagePoint;
use seidel_optics::observations::{Observation, ObservationSet};
use seidel_optics::predict::{Predictor, predict_set};
use seidel_optics::profile::{Controls, LensProfile, Look};
use seidel_optics::psf::{self, LocalBlur};
use seidel_optics::tile::Tile;
use seidel_render::KernelStore;
use std::sync::Arc;

use crate::placement::LensFrame;

/// Largest side of a tile that [`Lens::psf_at`] draws, pixels.
const MAX_TILE_PX: usize = 4096;

/// A fitted lens: its profile, and the predictor of its blur at any point of the field.
///
/// It keeps up to 160 MiB of kernels that renders drew ray by ray: the next render with the same lens, of another frame or
/// with another mask, draws only what is new. They change no result.
///
/// ```
/// # fn main() -> seidel_core::Result<()> {
/// # let text = include_str!("../tests/data/lens.json");
/// use seidel_core::{ImagePoint, Lens, ObjectDistance};
///
/// let lens = Lens::from_json(text)?;
/// let corner = ImagePoint::new(60.0, 40.0);
/// let blur = lens.blur_at("G", corner, ObjectDistance::metres(2.0)?)?;
/// assert!(blur.moments.mu20 > 0.0);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Lens {
    profile: LensProfile,
    predictor: Predictor,
    /// Kernels that renders have drawn; clones and lenses with other controls share them.
    kernels: Arc<KernelStore>,
}

impl Lens {
    /// Creates the lens that `profile` describes.
    ///
    /// # Errors
    /// A profile whose parameters do not describe a lens.
    pub fn new(profile: LensProfile) -> Result<Self> {
        Ok(Self {
            predictor: Predictor::new(&profile)?,
            profile,
            kernels: Arc::default(),
        })
    }

    /// Reads a lens profile from the JSON text that [`Lens::to_json`] writes.
    ///
    /// # Errors
    /// Text that is not a lens profile of a known version; the field at fault is named.
    pub fn from_json(text: &str) -> Result<Self> {
        Self::new(LensProfile::from_json(text)?)
    }

    /// Returns the lens profile as JSON.
    pub fn to_json(&self) -> String {
        self.profile.to_json()
    }

    /// The squeeze of an anamorphic lens, as its camera states it; 1 for a spherical lens.
    pub fn squeeze(&self) -> f64 {
        self.profile.camera.squeeze.unwrap_or(1.0)
    }

    /// The frame, as plates are placed in it.
    pub fn frame(&self) -> LensFrame {
        LensFrame {
            frame: self.profile.frame,
            squeeze: self.squeeze(),
            pixel_pitch_um: self.profile.pixel_pitch_um,
        }
    }

    /// The lens profile.
    pub fn profile(&self) -> &LensProfile {
        &self.profile
    }

    /// The predictor of the lens's blur.
    pub fn predictor(&self) -> &Predictor {
        &self.predictor
    }

    /// Returns the blur of `channel` at frame pixel `at` for an object at `distance`: central moments in frame pixels,
    /// without the area of a sensor pixel.
    ///
    /// # Errors
    /// A channel that the lens lacks, and an unknown distance where the blur depends on it.
    pub fn blur_at(
        &self,
        channel: &str,
        at: ImagePoint,
        distance: ObjectDistance,
    ) -> Result<LocalBlur> {
        let channel = self.predictor.channel_index(channel)?;
        let vergence = self.predictor.vergence(distance)?;
        let field = self.predictor.frame().field_point(at);
        Ok(self.predictor.blur_at(channel, field, vergence).blur)
    }

    /// Returns the PSF at frame pixel `at` for an object at `distance`, drawn by the PSF model `model`: a tile of
    /// `size_px` x `size_px` frame pixels for each channel, with its centroid at `at` and a sum of 1. The best model for
    /// the lens is used if `model` is `None`.
    ///
    /// # Errors
    /// A size of zero or above 4096, an unknown model or one that cannot draw the lens, an unknown distance where the blur
    /// depends on it, and a PSF that lies outside its tile.
    pub fn psf_at(
        &self,
        at: ImagePoint,
        distance: ObjectDistance,
        size_px: usize,
        model: Option<&str>,
    ) -> Result<Vec<Tile>> {
        if !(1..=MAX_TILE_PX).contains(&size_px) {
            return Err(Error::new(
                "size",
                format!("is {size_px}"),
                format!("give a number of pixels from 1 to {MAX_TILE_PX}"),
            ));
        }
        let model = model.map(psf::by_id).transpose()?;
        let model = model.unwrap_or_else(|| self.predictor.default_model());
        let centre = centred_point(size_px)?;
        let channels = self.predictor.channel_names().to_vec();
        let tiles = vec![centre; channels.len()];
        let template = Observation::new(String::new(), at, distance, tiles);
        let template = ObservationSet::new(self.profile.frame, channels, vec![template]);
        let mut predicted = predict_set(&self.predictor, &template, model)?;
        Ok(predicted.observations.swap_remove(0).tiles)
    }

    /// Returns the lens with the focus, f-number and sensor shift of `controls`.
    ///
    /// # Errors
    /// Those of [`LensProfile::with_controls`].
    pub fn with_controls(&self, controls: &Controls) -> Result<Self> {
        if controls.is_empty() {
            return Ok(self.clone());
        }
        let profile = self.profile.with_controls(controls).map_err(|error| {
            if self.predictor.has_rays() {
                error
            } else {
                error.with_kind(ErrorKind::Unsupported)
            }
        })?;
        self.sharing_kernels(profile)
    }

    /// Returns the lens with `look`.
    ///
    /// # Errors
    /// Those of [`LensProfile::with_look`].
    pub fn with_look(&self, look: &Look) -> Result<Self> {
        if look.is_neutral() {
            return Ok(self.clone());
        }
        self.sharing_kernels(self.profile.with_look(look)?)
    }

    /// Returns the lens of `profile`, which uses the kernels of this one.
    fn sharing_kernels(&self, profile: LensProfile) -> Result<Self> {
        Ok(Self {
            kernels: Arc::clone(&self.kernels),
            ..Self::new(profile)?
        })
    }

    /// Returns the kernels that renders have drawn.
    pub(crate) fn kernels(&self) -> &KernelStore {
        &self.kernels
    }
}

/// Returns a tile whose only light is a point at its centre: one pixel, or four where `size_px` is even.
fn centred_point(size_px: usize) -> Result<Tile> {
    let (first, last) = ((size_px - 1) / 2, size_px / 2);
    let is_centre = |k: usize| (first..=last).contains(&k);
    let light = (0..size_px * size_px)
        .map(|k| f32::from(u8::from(is_centre(k % size_px) && is_centre(k / size_px))));
    Tile::new(size_px, size_px, light.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn psfs_have_unit_sum_and_lie_at_the_centre_of_their_tile() {
        let text = include_str!("../tests/data/lens.json");
        let lens = Lens::from_json(text).expect("a lens");
        let distance = ObjectDistance::metres(2.5).expect("a distance");
        let at = ImagePoint::new(700.25, 100.0);
        for size in [40, 41] {
            let tiles = lens.psf_at(at, distance, size, None).expect("a PSF");
            assert_eq!(tiles.len(), lens.predictor().channel_names().len());
            for tile in tiles {
                assert!((tile.sum() - 1.0).abs() < 1e-3, "{}", tile.sum());
                let x = (tile.samples().iter().enumerate())
                    .map(|(k, v)| f64::from(*v) * ((k % size) as f64 + 0.5));
                let x = x.sum::<f64>() / tile.sum();
                assert!((x - size as f64 / 2.0).abs() < 0.05, "{x}");
            }
        }
        assert!(lens.psf_at(at, distance, 0, None).is_err());
        assert!(lens.psf_at(at, distance, 9, Some("none")).is_err());
        assert!(lens.psf_at(at, ObjectDistance::Unknown, 41, None).is_err());
    }
}
