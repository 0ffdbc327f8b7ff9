//! The colour error of a lens, without the blur that all channels share.

use crate::{BlurField, DisplacedBlur};
use seidel_optics::field::{FieldPoint, Frame};
use seidel_optics::sensor::Tone;

/// A lens without the blur that its channels share: its axial and lateral colour alone.
///
/// At every point and distance the sharpest channel, that of the least variance, becomes a point. The PSF of another channel is
/// scaled until its variance is the excess over the least one. Kernels stay as positive as those of the lens, and displacements as
/// they are. Where channels are alike, none blurs.
pub struct ChromaticLens<'a> {
    lens: &'a dyn BlurField,
}

impl<'a> ChromaticLens<'a> {
    /// Wraps `lens`.
    pub fn new(lens: &'a dyn BlurField) -> Self {
        Self { lens }
    }

    /// Returns the blur of `channel` of those that `blur_of` gives, without what all share.
    fn excess(&self, channel: usize, blur_of: impl Fn(usize) -> DisplacedBlur) -> DisplacedBlur {
        let variance = |placed: &DisplacedBlur| {
            let moments = &placed.blur.moments;
            moments.mu20 + moments.mu02
        };
        let own = blur_of(channel);
        let total = variance(&own);
        let others = (0..self.lens.channel_count()).filter(|other| *other != channel);
        let least = others
            .map(|other| variance(&blur_of(other)))
            .fold(total, f64::min);
        let scale = if total > least {
            ((total - least) / total).sqrt()
        } else {
            0.0
        };
        DisplacedBlur {
            blur: own.blur.rescaled(scale),
            ..own
        }
    }
}

impl BlurField for ChromaticLens<'_> {
    fn frame(&self) -> Frame {
        self.lens.frame()
    }

    fn channel_count(&self) -> usize {
        self.lens.channel_count()
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        self.excess(channel, |k| self.lens.blur_at(k, at, vergence_per_m))
    }

    fn unclamped_blur_at(
        &self,
        channel: usize,
        at: FieldPoint,
        vergence_per_m: f64,
    ) -> DisplacedBlur {
        self.excess(channel, |k| {
            self.lens.unclamped_blur_at(k, at, vergence_per_m)
        })
    }

    fn tone(&self, channel: usize) -> Tone {
        self.lens.tone(channel)
    }
}
