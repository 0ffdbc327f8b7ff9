//! A lens on pixels that are not square, as those of anamorphic plates and some video.

use crate::{BlurField, DisplacedBlur};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::sensor::Tone;

/// Largest pixel aspect, and one over the smallest.
pub const MAX_PIXEL_ASPECT: f64 = 16.0;

/// A lens with a frame of pixels that are `pixel_aspect` times as wide as they are high.
///
/// Frame, displacement and blur are those of the lens with lengths along x divided by the aspect
/// ([`LocalBlur::on_wider_pixels`](seidel_optics::psf::LocalBlur::on_wider_pixels)). A [`PlateMap`](crate::PlateMap) for
/// this lens is in pixels of its frame, with one scale along both axes. With square pixels use the lens itself.
pub struct NonSquarePixelLens<'a> {
    lens: &'a dyn BlurField,
    pixel_aspect: f64,
    frame: Frame,
    /// Half frame widths of the lens per half width of this frame, along x and y.
    units: [f64; 2],
}

impl<'a> NonSquarePixelLens<'a> {
    /// Wraps `lens` for pixels that are `pixel_aspect` times as wide as they are high.
    ///
    /// # Errors
    /// An aspect that is not from 1 / [`MAX_PIXEL_ASPECT`] to [`MAX_PIXEL_ASPECT`].
    pub fn new(lens: &'a dyn BlurField, pixel_aspect: f64) -> Result<Self> {
        if !(1.0 / MAX_PIXEL_ASPECT..=MAX_PIXEL_ASPECT).contains(&pixel_aspect) {
            return Err(Error::new(
                "pixel aspect",
                format!("is {pixel_aspect}"),
                format!(
                    "give the width of a pixel over its height, from 1/{MAX_PIXEL_ASPECT} to \
                     {MAX_PIXEL_ASPECT}; 1 for square pixels"
                ),
            ));
        }
        let whole = lens.frame();
        // Rounded up to whole pixels; `units` accounts for the rest.
        let width = (f64::from(whole.width_px()) / pixel_aspect).ceil();
        let axis = ImagePoint::new(whole.axis().x_px / pixel_aspect, whole.axis().y_px);
        let frame = Frame::new(width as u32, whole.height_px(), Some(axis))?;
        let unit = frame.half_width_px() / whole.half_width_px();
        Ok(Self {
            lens,
            pixel_aspect,
            frame,
            units: [unit * pixel_aspect, unit],
        })
    }
}

impl BlurField for NonSquarePixelLens<'_> {
    fn frame(&self) -> Frame {
        self.frame
    }

    fn channel_count(&self) -> usize {
        self.lens.channel_count()
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence_per_m: f64) -> DisplacedBlur {
        let at = FieldPoint::new(at.x * self.units[0], at.y * self.units[1]);
        let placed = self.lens.blur_at(channel, at, vergence_per_m);
        let (x, y) = placed.displacement_px;
        DisplacedBlur {
            blur: placed.blur.on_wider_pixels(self.pixel_aspect),
            displacement_px: (x / self.pixel_aspect, y),
        }
    }

    fn tone(&self, channel: usize) -> Tone {
        self.lens.tone(channel)
    }
}

#[cfg(test)]
mod tests;
