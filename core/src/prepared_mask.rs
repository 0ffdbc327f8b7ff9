//! The mask of a plate: a weight of its blurred pixels, or a factor of the blur itself.

use seidel_optics::error::{Error, Result};
use seidel_render::{RenderWindow, VergencePass};

use crate::margins::Margins;
use crate::placement::PlatePlacement;
use crate::plate::check_matte;
use crate::prepared_depth::PreparedDepth;
use crate::session::LensSession;
use crate::settings::MaskScales;

/// A mask, and the vergences of the plate where it scales the blur.
pub(crate) struct PreparedMask {
    samples: Vec<f32>,
    vergence: Option<Vec<f32>>,
}

impl PreparedMask {
    /// Reads the `samples` of the mask of a plate at `placement` with this `depth`.
    ///
    /// # Errors
    /// A mask of another size, the first sample that is not from 0 to 1, by its pixel, and a mask of the blur of a lens without a
    /// focus.
    pub(crate) fn new(
        session: &LensSession,
        placement: &PlatePlacement,
        depth: &PreparedDepth,
        samples: Vec<f32>,
    ) -> Result<Self> {
        let PlatePlacement { width, height, .. } = *placement;
        if samples.len() != width * height {
            return Err(Error::new(
                "mask",
                format!("has {} samples", samples.len()),
                format!("give one for each pixel of the plate, {width} x {height}"),
            ));
        }
        check_matte("mask", &samples, width)?;
        let scales_blur = session.settings().mask_scales == MaskScales::Blur;
        let vergence = if scales_blur && !session.is_neutral() {
            let range = session.focus_range()?;
            let moved = |(index, share): (usize, &f32)| {
                let vergence = match depth.vergence() {
                    VergencePass::Constant(vergence) => vergence,
                    VergencePass::PerPixel(pass) => f64::from(pass[index]),
                };
                range.nearer_focus(vergence, f64::from(*share)) as f32
            };
            Some(samples.iter().enumerate().map(moved).collect())
        } else {
            None
        };
        Ok(Self { samples, vergence })
    }

    /// Returns the mask of a plate `width` columns wide with `margins` about it, which repeat the nearest pixel.
    pub(crate) fn padded(&self, margins: Margins, width: usize) -> Self {
        let padded = |samples: &Vec<f32>| margins.padded(samples, width, |v| v);
        Self {
            samples: padded(&self.samples),
            vergence: self.vergence.as_ref().map(padded),
        }
    }

    /// The vergences to render in place of those of the depth, where the mask scales the blur.
    pub(crate) fn vergence(&self) -> Option<VergencePass<'_>> {
        self.vergence.as_deref().map(VergencePass::PerPixel)
    }
}

/// The weights of a blurred plate against its own pixels.
pub(crate) struct MixWeights<'a> {
    mix: f32,
    mask: Option<&'a [f32]>,
}

impl<'a> MixWeights<'a> {
    /// Returns the weights of the settings of `session` and a `mask`; `None` if they are 1 everywhere.
    pub(crate) fn new(session: &LensSession, mask: Option<&'a PreparedMask>) -> Option<Self> {
        let settings = session.settings();
        let mask = mask.filter(|_| settings.mask_scales == MaskScales::Mix);
        let weights = Self {
            mix: settings.mix as f32,
            mask: mask.map(|mask| mask.samples.as_slice()),
        };
        (weights.mix != 1.0 || weights.mask.is_some()).then_some(weights)
    }

    /// Mixes `planes`, a `part` of a plate `width` columns wide, with the plate's `own`.
    pub(crate) fn mix(
        &self,
        part: RenderWindow,
        width: usize,
        own: &[Vec<f32>],
        planes: &mut [Vec<f32>],
    ) {
        for (plane, own) in planes.iter_mut().zip(own) {
            for (row, samples) in plane.chunks_exact_mut(part.width).enumerate() {
                let first = (part.row + row) * width + part.column;
                for (index, sample) in (first..).zip(samples) {
                    let weight = self.mask.map_or(self.mix, |mask| self.mix * mask[index]);
                    // A separate case, so that a weight of 1 changes no bit.
                    if weight != 1.0 {
                        *sample = own[index] + weight * (*sample - own[index]);
                    }
                }
            }
        }
    }
}
