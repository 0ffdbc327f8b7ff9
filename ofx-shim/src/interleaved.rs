//! Interleaved images of the plugin's own, in which a result is complete before the host's image changes.

use std::panic::resume_unwind;
use std::thread;

use seidel_core::Rectangle;

use crate::host::Result;
use crate::plate_image::{PlateImage, collect_rows};

/// An image of interleaved samples.
pub(crate) struct Interleaved {
    samples: Vec<f32>,
    rectangle: Rectangle,
    channels: usize,
}

impl Interleaved {
    /// Creates an image over `rectangle`, each row as `read` fills it from its first pixel on.
    ///
    /// # Errors
    /// Not enough memory.
    pub(crate) fn new(
        rectangle: Rectangle,
        channels: usize,
        read: impl FnMut((i32, i32), &mut [f32]),
    ) -> Result<Self> {
        Ok(Self {
            samples: collect_rows(rectangle, channels, read)?,
            rectangle,
            channels,
        })
    }

    /// Creates a copy of all of `image`.
    ///
    /// # Errors
    /// Not enough memory.
    pub(crate) fn copy_of(image: &PlateImage) -> Result<Self> {
        Self::new(image.rectangle(), image.channels(), |pixel, row| {
            image.read_pixels(pixel, row);
        })
    }

    /// The pixels of the image.
    pub(crate) fn rectangle(&self) -> Rectangle {
        self.rectangle
    }

    /// Returns a channel, row by row. It must exist.
    pub(crate) fn plane(&self, channel: usize) -> Vec<f32> {
        let samples = self.samples.iter().skip(channel);
        samples.step_by(self.channels).copied().collect()
    }

    /// Number of channels.
    pub(crate) fn channels(&self) -> usize {
        self.channels
    }

    /// Reads a channel of `pixel` and of those to its right, one a value; 0 outside the image. The channel must exist.
    pub(crate) fn read_channel(&self, pixel: (i32, i32), channel: usize, values: &mut [f32]) {
        let Rectangle { x, y, width, .. } = self.rectangle;
        values.fill(0.0);
        if !self.rectangle.rows().contains(&pixel.1) {
            return;
        }
        let row = (pixel.1 - y) as usize * width;
        for (column, value) in (pixel.0..).zip(values) {
            if self.rectangle.columns().contains(&column) {
                *value = self.samples[(row + (column - x) as usize) * self.channels + channel];
            }
        }
    }

    /// Returns the rows with the first pixel of each.
    pub(crate) fn rows_mut(&mut self) -> impl Iterator<Item = ((i32, i32), &mut [f32])> {
        let length = (self.rectangle.width * self.channels).max(1);
        let x = self.rectangle.x;
        let firsts = self.rectangle.rows().map(move |y| (x, y));
        firsts.zip(self.samples.chunks_exact_mut(length))
    }

    /// Returns the samples of a pixel, or `None` outside the image.
    pub(crate) fn pixel_mut(&mut self, x: i32, y: i32) -> Option<&mut [f32]> {
        let rectangle = self.rectangle;
        rectangle.contains(x, y).then(|| {
            let row = (y - rectangle.y) as usize * rectangle.width;
            let first = (row + (x - rectangle.x) as usize) * self.channels;
            &mut self.samples[first..first + self.channels]
        })
    }

    /// Writes the image to `target`, which has as many channels.
    pub(crate) fn write_to(&self, target: &PlateImage) {
        let length = (self.rectangle.width * self.channels).max(1);
        let rows = self.samples.chunks_exact(length);
        for (y, row) in self.rectangle.rows().zip(rows) {
            target.write_pixels((self.rectangle.x, y), row);
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
