//! A lens whose blur beyond a window of the plate is that at the window's edge.

use crate::{BlurField, DisplacedBlur, PlateMap, RenderWindow, Scene};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::sensor::Tone;

/// A lens whose blur beyond a window of the plate is that at the window's edge.
pub struct ClampedLens<'a> {
    lens: &'a dyn BlurField,
    /// Field point of the window's top-left outer corner.
    first: FieldPoint,
    /// Field point of its bottom-right outer corner.
    last: FieldPoint,
}

impl<'a> ClampedLens<'a> {
    /// Clamps the lens of `scene` to a `window` of its plate.
    pub fn new(scene: &Scene<'a>, window: RenderWindow) -> Self {
        let PlateMap { origin, scale } = scene.map;
        let corner = |x: usize, y: usize| {
            scene.lens.frame().field_point(ImagePoint::new(
                origin.x_px + x as f64 / scale,
                origin.y_px + y as f64 / scale,
            ))
        };
        Self {
            lens: scene.lens,
            first: corner(window.column, window.row),
            last: corner(window.column + window.width, window.row + window.height),
        }
    }
}

impl BlurField for ClampedLens<'_> {
    fn frame(&self) -> Frame {
        self.lens.frame()
    }

    fn channel_count(&self) -> usize {
        self.lens.channel_count()
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        let at = FieldPoint::new(
            at.x.clamp(self.first.x, self.last.x),
            at.y.clamp(self.first.y, self.last.y),
        );
        self.lens.blur_at(channel, at, vergence_per_m)
    }

    fn unclamped_blur_at(
        &self,
        channel: usize,
        at: FieldPoint,
        vergence_per_m: f64,
    ) -> DisplacedBlur {
        self.lens.unclamped_blur_at(channel, at, vergence_per_m)
    }

    fn tone(&self, channel: usize) -> Tone {
        self.lens.tone(channel)
    }
}
