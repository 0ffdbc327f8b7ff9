//! The result mixed with the source, by channel, mask and mix factor.

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
    pub(crate) channels: MixedChannels,
}

/// Channels that a result has; the others are those of the source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MixedChannels {
    All,
    Colours,
    Alpha,
}

impl MixedChannels {
    /// Returns whether the result has this channel, of an image of so many.
    fn contain(self, channel: usize, count: usize) -> bool {
        let is_alpha = count != 3 && channel + 1 == count;
        match self {
            Self::All => true,
            Self::Colours => !is_alpha,
            Self::Alpha => is_alpha,
        }
    }
}

impl Mixing<'_> {
    /// Replaces `result` by its mix with `source`, which has as many channels.
    pub(crate) fn apply(&self, result: &mut Interleaved, source: &PlateImage) {
        if self.mix == 1.0 && self.mask.is_none() && self.channels == MixedChannels::All {
            return;
        }
        let channels = result.channels();
        let is_mixed: Vec<bool> = (0..channels)
            .map(|channel| self.channels.contain(channel, channels))
            .collect();
        let (mut sharp, mut weights) = (Vec::new(), Vec::new());
        for (first, row) in result.rows_mut() {
            sharp.resize(row.len(), 0.0);
            weights.resize(row.len() / channels, 0.0);
            source.read_pixels(first, &mut sharp);
            self.read_weights(first, &mut weights);
            let pixels = row.chunks_exact_mut(channels);
            let pixels = pixels.zip(sharp.chunks_exact(channels)).zip(&weights);
            for ((after, before), weight) in pixels {
                for ((after, before), is_mixed) in after.iter_mut().zip(before).zip(&is_mixed) {
                    if !is_mixed || *weight == 0.0 {
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
    pub(crate) fn read_weights(&self, pixel: (i32, i32), weights: &mut [f32]) {
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
                channels: MixedChannels::All,
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

    #[test]
    fn channels_that_are_not_chosen_stay_those_of_the_source() {
        let kept = |channels, count| -> Vec<bool> {
            let contains = |channel| MixedChannels::contain(channels, channel, count);
            (0..count).map(contains).collect()
        };
        assert_eq!(kept(MixedChannels::Colours, 4), [true, true, true, false]);
        assert_eq!(kept(MixedChannels::Alpha, 4), [false, false, false, true]);
        assert_eq!(kept(MixedChannels::Alpha, 3), [false; 3]);
        assert_eq!(kept(MixedChannels::Alpha, 1), [true]);
        let mut source = [1.0; 4];
        let mut result = Interleaved::new(ROW, 1, |_, row| row.fill(3.0)).expect("memory");
        let mixing = Mixing {
            mix: 1.0,
            mask: None,
            invert_mask: false,
            channels: MixedChannels::Colours,
        };
        mixing.apply(&mut result, &image(&mut source));
        let mut values = [0.0; 4];
        result.read_channel((0, 0), 0, &mut values);
        assert_eq!(values, [1.0; 4]);
    }
}
