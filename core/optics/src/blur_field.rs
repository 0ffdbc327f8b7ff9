//! A lens as a renderer sees it.

use crate::field::{FieldPoint, Frame};
use crate::psf::LocalBlur;
use crate::sensor::Tone;

/// A lens as a renderer sees it: what it does to a point of light anywhere in field and depth.
pub trait BlurField: Sync {
    /// The lens's own full frame, in whose pixels blur and displacement are given.
    fn frame(&self) -> Frame;

    /// Number of colour channels.
    fn channel_count(&self) -> usize;

    /// Blur and displacement of `channel` at `at`, for an object at vergence `vergence_per_m` (1 /
    /// distance, 0 at infinity).
    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur;

    /// How the sensor's pixel values of `channel` follow from light: the same everywhere. Renderers
    /// leave it to [`apply_tone`].
    fn tone(&self, _channel: usize) -> Tone {
        Tone::default()
    }
}

/// Turns a rendered plane of light, in which white is one, into what the sensor behind `lens` records:
/// by the tone of each lens channel, weighed by the plane's channel `weights`. Coverage is not light:
/// alpha planes stay as they are.
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

/// The blur of a point and where its centroid lands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplacedBlur {
    /// Moments in pixels of the lens's frame, without any pixel's area.
    pub blur: LocalBlur,
    /// Centroid less ideal position, pixels of the lens's frame (x, y).
    pub displacement_px: (f64, f64),
}
