//! The result mixed with the source, by mask and mix factor.

use crate::interleaved::Interleaved;
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
    /// Replaces `result` by its mix with `source`, which has as many channels.
    pub(crate) fn apply(&self, result: &mut Interleaved, source: &PlateImage) {
        if self.mix == 1.0 && self.mask.is_none() {
            return;
        }
        let channels = result.channels();
        let (mut sharp, mut weights) = (Vec::new(), Vec::new());
        for (first, row) in result.rows_mut() {
            sharp.resize(row.len(), 0.0);
            weights.resize(row.len() / channels, 0.0);
            source.read_pixels(first, &mut sharp);
            self.read_weights(first, &mut weights);
            let pixels = row.chunks_exact_mut(channels);
            let pixels = pixels.zip(sharp.chunks_exact(channels)).zip(&weights);
            for ((after, before), weight) in pixels {
                for (after, before) in after.iter_mut().zip(before) {
                    if *weight == 0.0 {
                        // To the bit, even where the result is not finite.
                        *after = *before;
                    } else if *weight != 1.0 {
                        *after = before + (*after - before) * weight;
                    }
                }
            }
        }
    }

    /// Reads the weights of the result at `pixel` and those to its right. The mask is zero outside its image and where it is NaN.
    fn read_weights(&self, pixel: (i32, i32), weights: &mut [f32]) {
        let Some(mask) = self.mask else {
            weights.fill(self.mix);
            return;
        };
        mask.read_channel(pixel, mask.channels() - 1, weights);
        (weights.iter_mut()).for_each(|value| *value = self.weight(*value));
    }

    /// Returns the weight of the result where the mask has this value.
    fn weight(&self, value: f32) -> f32 {
        let value = if value.is_nan() { 0.0 } else { value };
        let value = value.clamp(0.0, 1.0);
        self.mix * if self.invert_mask { 1.0 - value } else { value }
    }
}

#[cfg(test)]
mod tests {
    use seidel_core::Rectangle;

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
            let mut result = Interleaved::new(ROW, 1, |_, row| row.fill(3.0)).expect("memory");
            let mixing = Mixing {
                mix,
                mask,
                invert_mask,
            };
            mixing.apply(&mut result, &source);
            let mut values = [0.0; 4];
            result.read_channel((0, 0), 0, &mut values);
            values
        };
        assert_eq!(mixed(1.0, None, false), [3.0; 4]);
        assert_eq!(mixed(0.5, None, false), [2.0; 4]);
        // Outside the mask its value is zero.
        assert_eq!(mixed(1.0, Some(mask), false), [1.0, 2.0, 3.0, 1.0]);
        assert_eq!(mixed(1.0, Some(mask), true), [3.0, 2.0, 1.0, 3.0]);
        assert_eq!(mixed(0.5, Some(mask), false), [1.0, 1.5, 2.0, 1.0]);
    }
}
