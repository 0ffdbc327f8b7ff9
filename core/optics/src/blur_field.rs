//! The interface between a lens and a renderer.

use crate::field::{FieldPoint, Frame};
use crate::psf::LocalBlur;
use crate::sensor::Tone;

/// The blur of a lens as a function of channel, field position and vergence.
///
/// Renderers read lenses through this trait only. [`crate::predict::Predictor`] implements it for lens profiles.
pub trait BlurField: Sync {
    /// The full frame of the lens. Blur and displacement are in its pixels.
    fn frame(&self) -> Frame;

    /// Number of colour channels.
    fn channel_count(&self) -> usize;

    /// Returns the blur and the displacement of `channel` at field position `at`, for an object at
    /// `vergence_per_m` (1 / distance in 1/m, 0 at infinity).
    ///
    /// # Panics
    /// May panic if `channel` is not below [`BlurField::channel_count`].
    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur;

    /// Returns the blur of the lens itself: [`BlurField::blur_at`], but for a lens that was clamped to a part of its frame.
    fn unclamped_blur_at(
        &self,
        channel: usize,
        at: FieldPoint,
        vergence_per_m: f64,
    ) -> DisplacedBlur {
        self.blur_at(channel, at, vergence_per_m)
    }

    /// The tone curve of the sensor in `channel`, the same over the whole frame.
    ///
    /// Renderers work on linear light and do not apply it; [`apply_tone`] does.
    fn tone(&self, _channel: usize) -> Tone {
        Tone::default()
    }
}

/// Applies the tone curve of the sensor behind `lens` to a rendered plane of linear light, in place.
///
/// White is one. A sample becomes the mean of the tone curves of the lens channels, weighted by `weights` (one
/// a lens channel, summing to one). Alpha planes hold coverage, not light: do not pass them.
pub fn apply_tone(lens: &dyn BlurField, weights: &[f64], plane: &mut [f32]) {
    let shares = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
    let tones: Vec<_> = shares.map(|(k, w)| (lens.tone(k), *w)).collect();
    if tones.iter().all(|(tone, _)| tone.is_linear()) {
        return;
    }
    for sample in plane {
        let light = f64::from(*sample);
        *sample = tones
            .iter()
            .map(|(tone, w)| w * tone.apply(light))
            .sum::<f64>() as f32;
    }
}

/// The blur of a point of light and the displacement of its centroid.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplacedBlur {
    /// The optical blur in pixels of the lens's frame, before integration over pixels.
    pub blur: LocalBlur,
    /// Centroid minus ideal position (x, y), in pixels of the lens's frame.
    pub displacement_px: (f64, f64),
}
