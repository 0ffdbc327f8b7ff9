//! The result mixed with the source, by mask and mix factor.

use seidel_core::Rectangle;

use crate::plate_image::PlateImage;

/// Weight of the result against the source.
#[derive(Clone, Copy)]
pub(crate) struct Mixing<'a> {
    /// Factor of all weights.
    pub(crate) mix: f32,
    /// Mask whose last channel is the weight; `None` is 1 everywhere.
    pub(crate) mask: Option<PlateImage<'a>>,
    pub(crate) invert_mask: bool,
}

impl Mixing<'_> {
    /// Replaces `result` by its mix with `source` in `rectangle`.
    pub(crate) fn apply(&self, result: &PlateImage, source: &PlateImage, rectangle: Rectangle) {
        if self.mix == 1.0 && self.mask.is_none() {
            return;
        }
        for pixel in result.pixels_in(rectangle) {
            let weight = self.weight(pixel);
            if weight == 1.0 {
                continue;
            }
            for channel in 0..result.channels() {
                let before = source.get(pixel, channel).unwrap_or(0.0);
                let mixed = if weight == 0.0 {
                    // To the bit, even where the result is not finite.
                    before
                } else {
                    let after = result.get(pixel, channel).unwrap_or(0.0);
                    before + (after - before) * weight
                };
                result.set(pixel, channel, mixed);
            }
        }
    }

    /// Returns the weight of the result at a pixel. The mask is zero outside its image and where it is NaN.
    fn weight(&self, pixel: (i32, i32)) -> f32 {
        let Some(mask) = self.mask else {
            return self.mix;
        };
        let value = mask.get(pixel, mask.channels() - 1).unwrap_or(0.0);
        let value = if value.is_nan() { 0.0 } else { value };
        let value = value.clamp(0.0, 1.0);
        self.mix * if self.invert_mask { 1.0 - value } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Field, PixelMap};
    use crate::host::Samples;
    use crate::sys::OfxRectI;

    const ROW: Rectangle = Rectangle {
        x: 0,
        y: 0,
        width: 4,
        height: 1,
    };

    fn image(samples: &mut [f32]) -> PlateImage<'_> {
        let row = |columns: i32| OfxRectI {
            x1: 0,
            y1: 0,
            x2: columns,
            y2: 1,
        };
        let map = PixelMap::new(row(4), Field::Whole);
        let bounds = row(samples.len() as i32);
        PlateImage::of_samples(Samples::of_slice(samples, bounds, 1), map).expect("a row")
    }

    #[test]
    fn mask_and_mix_weight_the_result() {
        let (mut mask, mut source) = ([0.0, 0.5, 1.0], [1.0, 1.0, 1.0, 1.0]);
        let (mask, source) = (image(&mut mask), image(&mut source));
        let mixed = |mix, mask, invert_mask| {
            let mut result = [3.0, 3.0, 3.0, 3.0];
            let mixing = Mixing {
                mix,
                mask,
                invert_mask,
            };
            mixing.apply(&image(&mut result), &source, ROW);
            result
        };
        assert_eq!(mixed(1.0, None, false), [3.0; 4]);
        assert_eq!(mixed(0.5, None, false), [2.0; 4]);
        // Outside the mask its value is zero.
        assert_eq!(mixed(1.0, Some(mask), false), [1.0, 2.0, 3.0, 1.0]);
        assert_eq!(mixed(1.0, Some(mask), true), [3.0, 2.0, 1.0, 3.0]);
        assert_eq!(mixed(0.5, Some(mask), false), [1.0, 1.5, 2.0, 1.0]);
    }
}
