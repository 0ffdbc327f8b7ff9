//! Interleaved images of the plugin's own, for colour conversion.

use std::panic::resume_unwind;
use std::thread;

use seidel_core::Rectangle;

use crate::host::Result;
use crate::plate_image::{PlateImage, collect_samples, pixels_of};

/// An image of interleaved samples.
pub(crate) struct Interleaved {
    samples: Vec<f32>,
    rectangle: Rectangle,
    channels: usize,
}

impl Interleaved {
    /// Creates an image over `rectangle` whose samples are given by `sample`.
    ///
    /// # Errors
    /// Not enough memory.
    pub(crate) fn new(
        rectangle: Rectangle,
        channels: usize,
        sample: impl Fn((i32, i32), usize) -> f32,
    ) -> Result<Self> {
        Ok(Self {
            samples: collect_samples(rectangle, channels, sample)?,
            rectangle,
            channels,
        })
    }

    /// Creates a copy of all of `image`.
    ///
    /// # Errors
    /// Not enough memory.
    pub(crate) fn copy_of(image: &PlateImage) -> Result<Self> {
        let sample = |pixel, channel| image.get(pixel, channel).unwrap_or(0.0);
        Self::new(image.rectangle(), image.channels(), sample)
    }

    /// Number of channels.
    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    /// Returns a sample, or `None` outside the image. The channel must exist.
    pub(crate) fn get(&self, pixel: (i32, i32), channel: usize) -> Option<f32> {
        let rectangle = self.rectangle;
        rectangle.contains(pixel.0, pixel.1).then(|| {
            let row = (pixel.1 - rectangle.y) as usize;
            let column = (pixel.0 - rectangle.x) as usize;
            self.samples[(row * rectangle.width + column) * self.channels + channel]
        })
    }

    /// Writes the image to `target`, which has as many channels.
    pub(crate) fn write_to(&self, target: &PlateImage) {
        let pixels = pixels_of(self.rectangle).zip(self.samples.chunks_exact(self.channels));
        for (pixel, samples) in pixels {
            for (channel, sample) in samples.iter().enumerate() {
                target.set(pixel, channel, *sample);
            }
        }
    }

    /// Changes the image in parts of whole pixels, each on a thread of its own, and returns what `change` returns for each.
    /// There are at most `threads` parts, or as many as the machine has threads if that is 0. The threads end with the
    /// call, since none may be left in a library that hosts unload.
    pub(crate) fn for_each_part<R: Send>(
        &mut self,
        threads: u32,
        change: impl Fn(&mut [f32]) -> R + Sync,
    ) -> Vec<R> {
        let threads = match threads {
            0 => thread::available_parallelism().map_or(1, usize::from),
            threads => threads as usize,
        };
        let channels = self.channels.max(1);
        let pixels = self.samples.len() / channels;
        let part_length = pixels.div_ceil(threads).max(1) * channels;
        thread::scope(|scope| {
            let change = &change;
            let parts = self.samples.chunks_mut(part_length);
            let running: Vec<_> = parts
                .map(|part| scope.spawn(move || change(part)))
                .collect();
            running
                .into_iter()
                .map(|part| part.join().unwrap_or_else(|panic| resume_unwind(panic)))
                .collect()
        })
    }
}
