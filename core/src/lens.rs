//! A fitted lens.

use seidel_optics::BlurField;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{ErrorKind, Result};
use seidel_optics::field::ImagePoint;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{Controls, LensProfile};
use seidel_optics::psf::LocalBlur;

/// A fitted lens: its profile, and the predictor of its blur at any point of the field.
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
        Self::new(profile)
    }
}
