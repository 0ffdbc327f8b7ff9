//! A background prepared for the renders of its plate: planes like the plate's, and vergences.

use seidel_optics::error::{Error, Result};

use crate::light_scale::LightScale;
use crate::margins::Margins;
use crate::planes::{PlaneLayout, PremultipliedPlanes};
use crate::plate::{Background, PlateGeometry};
use crate::prepared_depth::PreparedDepth;
use crate::session::LensSession;
use seidel_optics::predict::Predictor;
use seidel_render::VergencePass;

/// A background prepared for the renders of its plate: planes in the order of the plate's, and vergences.
#[derive(Debug, Clone)]
pub struct PreparedBackground {
    planes: PremultipliedPlanes,
    depth: PreparedDepth,
}

impl PreparedBackground {
    /// Prepares the `background` of a plate of `geometry` for the lens of `session`.
    ///
    /// # Errors
    /// Planes of wrong size or with samples that are not finite, and those of [`PreparedDepth::new`].
    pub fn new(
        session: &LensSession,
        geometry: &PlateGeometry,
        background: Background,
    ) -> Result<Self> {
        let Background { image, depth } = background;
        let (own, plate) = ((image.width(), image.height()), geometry.data);
        if own != (plate.width, plate.height) {
            return Err(Error::new(
                "image",
                format!("is {} x {}", own.0, own.1),
                format!(
                    "give one of the plate's size, {} x {}",
                    plate.width, plate.height
                ),
            ));
        }
        let depth = PreparedDepth::new(session, geometry, depth);
        Ok(Self {
            planes: PremultipliedPlanes::new(image)?,
            depth: depth.map_err(|e| e.within("depth"))?,
        })
    }

    /// Orders the planes as those of a plate of `layout`.
    ///
    /// # Errors
    /// A background without a colour of the plate.
    pub(crate) fn with_layout(self, layout: &PlaneLayout) -> Result<Self> {
        Ok(Self {
            planes: self.planes.with_layout(layout)?,
            depth: self.depth,
        })
    }

    /// Returns the background of a plate `width` columns wide with `margins` of transparent black about it.
    pub(crate) fn padded(&self, margins: Margins, width: usize) -> Self {
        Self {
            planes: self.planes.padded(margins),
            depth: self.depth.padded(margins, width),
        }
    }

    /// Returns the background as the light that the sensor of `lens` recorded.
    pub(crate) fn undeveloped(&self, lens: &Predictor, weights: &[Vec<f64>]) -> Self {
        let mut light = self.clone();
        light.planes.undevelop(lens, weights);
        light
    }

    /// Largest magnitude of a colour sample.
    pub(crate) fn peak(&self) -> f64 {
        self.planes.peak()
    }

    /// Returns the background with colours multiplied by a scale.
    pub(crate) fn reduced_by(&self, scale: LightScale) -> Self {
        Self {
            planes: self.planes.reduced_by(scale),
            depth: self.depth.clone(),
        }
    }

    pub(crate) fn light(&self) -> &PremultipliedPlanes {
        &self.planes
    }

    pub(crate) fn planes(&self) -> Vec<&[f32]> {
        self.planes.planes().iter().map(Vec::as_slice).collect()
    }

    pub(crate) fn vergence(&self) -> VergencePass<'_> {
        self.depth.vergence()
    }
}
