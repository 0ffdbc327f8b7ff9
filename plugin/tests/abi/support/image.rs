//! Images of packed floats, as the C ABI takes them.

use seidel_c::{SEIDEL_FLOAT, SeidelImage, SeidelRect};

/// An image of packed floats.
#[derive(Clone)]
pub(crate) struct TestImage {
    pub(crate) rect: SeidelRect,
    pub(crate) channels: usize,
    pub(crate) samples: Vec<f32>,
}

impl TestImage {
    pub(crate) fn black(rect: SeidelRect, channels: usize) -> Self {
        let count = (rect.width * rect.height) as usize * channels;
        Self {
            rect,
            channels,
            samples: vec![0.0; count],
        }
    }

    /// Creates an image from a function of plate pixel and channel.
    pub(crate) fn from_fn(
        rect: SeidelRect,
        channels: usize,
        sample_at: impl Fn(i32, i32, usize) -> f32,
    ) -> Self {
        let mut image = Self::black(rect, channels);
        for (k, sample) in image.samples.iter_mut().enumerate() {
            let pixel = (k / channels) as i32;
            let (x, y) = (pixel % rect.width, pixel / rect.width);
            *sample = sample_at(rect.left + x, rect.top + y, k % channels);
        }
        image
    }

    /// Creates an image with a ramp, an edge and point lights; the last of 2 or 4 channels is alpha.
    pub(crate) fn pattern(rect: SeidelRect, channels: usize) -> Self {
        Self::from_fn(rect, channels, |x, y, channel| {
            if channels.is_multiple_of(2) && channel + 1 == channels {
                return if x < 20 { 0.5 } else { 1.0 };
            }
            let light = if x % 17 == 3 && y % 13 == 5 {
                40.0
            } else {
                0.0
            };
            let edge = if x > 60 { 0.6 } else { 0.1 };
            let shade = [1.0, 0.8, 0.5, 1.0][channel];
            shade * (light + edge + 0.003 * y as f32)
        })
    }

    pub(crate) fn input(&self) -> SeidelImage {
        SeidelImage {
            size: size_of::<SeidelImage>() as u64,
            data: self.samples.as_ptr().cast_mut().cast(),
            row_bytes: i64::from(self.rect.width) * self.channels as i64 * 4,
            pixel_bytes: 0,
            channels: self.channels as u32,
            sample: SEIDEL_FLOAT,
            reserved: 0,
            rect: self.rect,
        }
    }

    /// Returns the image as an output, through which its samples may be written.
    pub(crate) fn output(&mut self) -> SeidelImage {
        SeidelImage {
            data: self.samples.as_mut_ptr().cast(),
            ..self.input()
        }
    }

    /// Returns the part of the image in `rect`.
    pub(crate) fn cut(&self, rect: SeidelRect) -> Self {
        Self::from_fn(rect, self.channels, |x, y, channel| {
            let (x, y) = (x - self.rect.left, y - self.rect.top);
            let pixel = (y * self.rect.width + x) as usize;
            self.samples[pixel * self.channels + channel]
        })
    }

    pub(crate) fn plane(&self, channel: usize) -> Vec<f32> {
        let pixels = self.samples.chunks_exact(self.channels);
        pixels.map(|pixel| pixel[channel]).collect()
    }

    pub(crate) fn bits(&self) -> Vec<u32> {
        self.samples.iter().map(|v| v.to_bits()).collect()
    }
}

/// Returns the largest difference of two planes.
pub(crate) fn max_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f32::max)
}
