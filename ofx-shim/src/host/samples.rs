//! Samples of images in the host's memory.

use std::marker::PhantomData;

use half::f16;

use super::Image;
use crate::sys::OfxRectI;

/// The samples of an image in the host's memory: rows in either order, at any distance and address.
#[derive(Clone, Copy)]
pub(crate) struct Samples<'a> {
    /// First sample of the bottom left pixel.
    data: *mut u8,
    /// Bytes from a row to the one above it.
    row_bytes: i64,
    pixel_bytes: i64,
    is_half: bool,
    channels: usize,
    bounds: OfxRectI,
    image: PhantomData<&'a ()>,
}

impl Image<'_> {
    /// The samples of the image.
    pub(crate) fn samples(&self) -> Samples<'_> {
        Samples {
            data: self.data.cast(),
            row_bytes: self.row_bytes,
            pixel_bytes: self.pixel_bytes(),
            is_half: self.half,
            channels: self.channels as usize,
            bounds: self.bounds,
            image: PhantomData,
        }
    }
}

impl Samples<'_> {
    /// Number of channels.
    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    /// The pixels that exist, y up.
    pub(crate) fn bounds(&self) -> OfxRectI {
        self.bounds
    }

    /// Returns a sample of pixel (`x`, `y`), y up, or `None` outside the bounds and channels.
    pub(crate) fn get(&self, x: i32, y: i32, channel: usize) -> Option<f32> {
        let at = self.address(x, y, channel)?;
        Some(if self.is_half {
            // SAFETY: within the image, whose memory the host keeps until the image is released.
            f16::from_bits(unsafe { at.cast::<u16>().read_unaligned() }).to_f32()
        } else {
            // SAFETY: as above.
            unsafe { at.cast::<f32>().read_unaligned() }
        })
    }

    /// Reads a channel of pixel (`x`, `y`) and of those to its right, one a value. All must lie within the bounds.
    pub(crate) fn read_channel(&self, x: i32, y: i32, channel: usize, values: &mut [f32]) {
        let Some(first) = self.address_of_row(x, y, channel, values.len()) else {
            return;
        };
        let pixel_bytes = self.pixel_bytes as usize;
        if self.is_half {
            for (k, value) in values.iter_mut().enumerate() {
                let at = first.wrapping_add(k * pixel_bytes).cast::<u16>();
                // SAFETY: within the row, as `address_of_row` found.
                *value = f16::from_bits(unsafe { at.read_unaligned() }).to_f32();
            }
        } else {
            for (k, value) in values.iter_mut().enumerate() {
                let at = first.wrapping_add(k * pixel_bytes).cast::<f32>();
                // SAFETY: as above.
                *value = unsafe { at.read_unaligned() };
            }
        }
    }

    /// Reads all channels of pixel (`x`, `y`) and of those to its right, interleaved. All must lie within the bounds.
    pub(crate) fn read_pixels(&self, x: i32, y: i32, values: &mut [f32]) {
        let Some(first) = self.address_of_row(x, y, 0, values.len() / self.channels) else {
            return;
        };
        if self.is_half {
            for (k, value) in values.iter_mut().enumerate() {
                let at = first.wrapping_add(2 * k).cast::<u16>();
                // SAFETY: within the row, as `address_of_row` found; its samples have no gaps.
                *value = f16::from_bits(unsafe { at.read_unaligned() }).to_f32();
            }
        } else {
            // SAFETY: as above, and the values do not lie in the host's image.
            unsafe {
                first.copy_to_nonoverlapping(values.as_mut_ptr().cast(), size_of_val(values));
            }
        }
    }

    /// Writes all channels of pixel (`x`, `y`) of an output image and of those to its right, interleaved. All must lie within the
    /// bounds.
    pub(crate) fn write_pixels(&self, x: i32, y: i32, values: &[f32]) {
        let Some(first) = self.address_of_row(x, y, 0, values.len() / self.channels) else {
            return;
        };
        if self.is_half {
            for (k, value) in values.iter().enumerate() {
                let at = first.wrapping_add(2 * k).cast::<u16>();
                // SAFETY: within the row of an image that the host lends for writing until it is released.
                unsafe { at.write_unaligned(f16::from_f32(*value).to_bits()) };
            }
        } else {
            // SAFETY: as above, and the values do not lie in the host's image.
            unsafe {
                first.copy_from_nonoverlapping(values.as_ptr().cast(), size_of_val(values));
            }
        }
    }

    /// Returns the address of a sample with `count` pixels from its own on in its row, or `None` if the row has fewer.
    fn address_of_row(&self, x: i32, y: i32, channel: usize, count: usize) -> Option<*mut u8> {
        let last = x.checked_add(i32::try_from(count).ok()?.checked_sub(1)?)?;
        self.address(last, y, channel)?;
        self.address(x, y, channel)
    }

    fn address(&self, x: i32, y: i32, channel: usize) -> Option<*mut u8> {
        let OfxRectI { x1, y1, x2, y2 } = self.bounds;
        if !(x1..x2).contains(&x) || !(y1..y2).contains(&y) || channel >= self.channels {
            return None;
        }
        let sample_bytes = if self.is_half { 2 } else { 4 };
        let offset = i64::from(y - y1) * self.row_bytes
            + i64::from(x - x1) * self.pixel_bytes
            + channel as i64 * sample_bytes;
        Some(self.data.wrapping_offset(offset as isize))
    }
}

#[cfg(test)]
impl<'a> Samples<'a> {
    /// The `samples` of an image with `bounds` and `channels`, rows from the bottom up.
    pub(crate) fn of_slice(samples: &'a mut [f32], bounds: OfxRectI, channels: usize) -> Self {
        let columns = (bounds.x2 - bounds.x1) as usize;
        let rows = (bounds.y2 - bounds.y1) as usize;
        assert_eq!(samples.len(), columns * rows * channels);
        Self {
            data: samples.as_mut_ptr().cast(),
            row_bytes: (4 * columns * channels) as i64,
            pixel_bytes: 4 * channels as i64,
            is_half: false,
            channels,
            bounds,
            image: PhantomData,
        }
    }

    /// The same memory with its rows from the top down.
    pub(crate) fn upside_down(self) -> Self {
        let rows = i64::from(self.bounds.y2 - self.bounds.y1);
        let top = self
            .data
            .wrapping_offset(((rows - 1) * self.row_bytes) as isize);
        Self {
            data: top,
            row_bytes: -self.row_bytes,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_may_be_stored_in_either_order() {
        let mut values = [1.0, 2.0, 3.0, 4.0];
        let bounds = OfxRectI {
            x1: -1,
            y1: 5,
            x2: 0,
            y2: 7,
        };
        let samples = Samples::of_slice(&mut values, bounds, 2);
        assert_eq!(samples.get(-1, 5, 1), Some(2.0));
        assert_eq!(samples.get(-1, 6, 0), Some(3.0));
        assert_eq!(samples.upside_down().get(-1, 6, 0), Some(1.0));
        let read = |samples: Samples, x, count| {
            let mut values = vec![9.0; count];
            samples.read_pixels(x, 6, &mut values);
            values
        };
        assert_eq!(read(samples, -1, 2), [3.0, 4.0]);
        assert_eq!(read(samples.upside_down(), -1, 2), [1.0, 2.0]);
        // Rows that the image has not wholly are left alone.
        assert_eq!(read(samples, -1, 4), [9.0; 4]);
        assert_eq!(read(samples, 0, 2), [9.0; 2]);
        let outside = [(0, 5, 0), (-1, 4, 0), (-1, 7, 0), (-1, 5, 2)];
        for (x, y, channel) in outside {
            assert_eq!(samples.get(x, y, channel), None);
        }
        samples.write_pixels(-1, 6, &[7.0, 8.0]);
        samples.write_pixels(-1, 5, &[9.0; 4]);
        assert_eq!(values, [1.0, 2.0, 7.0, 8.0]);
    }

    #[test]
    fn half_precision_samples_are_converted() {
        let mut bits = [f16::from_f32(0.5).to_bits(), f16::from_f32(2.0).to_bits()];
        let samples = Samples {
            data: bits.as_mut_ptr().cast(),
            row_bytes: 4,
            pixel_bytes: 4,
            is_half: true,
            channels: 2,
            bounds: OfxRectI {
                x1: 0,
                y1: 0,
                x2: 1,
                y2: 1,
            },
            image: PhantomData,
        };
        assert_eq!(samples.get(0, 0, 1), Some(2.0));
        let mut pixel = [0.0; 2];
        samples.write_pixels(0, 0, &[0.5, 4.0]);
        samples.read_pixels(0, 0, &mut pixel);
        assert_eq!(pixel, [0.5, 4.0]);
        samples.read_channel(0, 0, 1, &mut pixel[..1]);
        assert_eq!(pixel[0], 4.0);
    }
}
