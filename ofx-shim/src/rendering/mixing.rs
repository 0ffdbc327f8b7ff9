//! The result over the source, by mask and mix.

use seidel_c::SeidelRect;

use crate::pixels::Pixels;

/// How much of the result goes over the source.
#[derive(Clone, Copy)]
pub(crate) struct Mixing {
    pub(crate) mix: f32,
    /// Its last channel counts; nothing: everywhere.
    pub(crate) mask: Option<Pixels>,
    pub(crate) invert: bool,
}

impl Mixing {
    /// Whether the result stays as it is.
    pub(crate) fn is_nothing(&self) -> bool {
        self.mix == 1.0 && self.mask.is_none()
    }

    /// Share of the result at a pixel.
    fn at(&self, place: (i32, i32)) -> f32 {
        let Some(mask) = self.mask else {
            return self.mix;
        };
        // Beyond a mask there is none; what is no number masks nothing out.
        let value = mask.get(place, mask.channels() - 1).unwrap_or(0.0);
        let value = if value.is_nan() { 0.0 } else { value };
        let value = value.clamp(0.0, 1.0);
        self.mix * if self.invert { 1.0 - value } else { value }
    }
}

/// Puts the source back over the result in `rect`, as far as `mixing` says.
pub(crate) fn mix(result: &Pixels, source: &Pixels, rect: SeidelRect, mixing: &Mixing) {
    if mixing.is_nothing() {
        return;
    }
    result.each(rect, |result, place| {
        let share = mixing.at(place);
        for channel in 0..result.channels() {
            let old = source.get(place, channel).unwrap_or(0.0);
            let new = match share {
                // To the bit, whatever the other is.
                0.0 => old,
                1.0 => continue,
                _ => old + (result.get(place, channel).unwrap_or(0.0) - old) * share,
            };
            result.put(place, channel, new);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_c::{SEIDEL_FLOAT, SeidelImage};

    const ROW: SeidelRect = SeidelRect {
        left: 0,
        top: 0,
        width: 4,
        height: 1,
    };

    fn pixels(samples: &mut [f32]) -> Pixels {
        let image = SeidelImage {
            size: size_of::<SeidelImage>() as u64,
            data: samples.as_mut_ptr().cast(),
            row_bytes: 4 * samples.len() as i64,
            pixel_bytes: 4,
            channels: 1,
            sample: SEIDEL_FLOAT,
            reserved: 0,
            rect: SeidelRect {
                width: samples.len() as i32,
                ..ROW
            },
        };
        // SAFETY: the samples outlive what is made of them in each test.
        unsafe { Pixels::new(image) }
    }

    #[test]
    fn masks_and_mix_bring_the_source_back() {
        let (mut mask, mut source) = ([0.0, 0.5, 1.0], [1.0, 1.0, 1.0, 1.0]);
        let (mask, source) = (pixels(&mut mask), pixels(&mut source));
        let mixed = |mix, mask, invert| {
            let mut out = [3.0_f32, 3.0, 3.0, 3.0];
            let result = pixels(&mut out);
            let mixing = Mixing { mix, mask, invert };
            super::mix(&result, &source, ROW, &mixing);
            out
        };
        assert_eq!(mixed(1.0, None, false), [3.0; 4]);
        assert_eq!(mixed(0.5, None, false), [2.0; 4]);
        // Beyond the mask nothing is masked in.
        assert_eq!(mixed(1.0, Some(mask), false), [1.0, 2.0, 3.0, 1.0]);
        assert_eq!(mixed(1.0, Some(mask), true), [3.0, 2.0, 1.0, 3.0]);
        assert_eq!(mixed(0.5, Some(mask), false), [1.0, 1.5, 2.0, 1.0]);
    }
}
