//! Images of the host in plate coordinates.

use seidel_core::Rectangle;

use crate::geometry::PixelMap;
use crate::host::{Failure, Image, Result, Samples};

/// An image of the host in plate coordinates: y down from the top of the format, and of a field its own rows. It can be
/// written if it is an output.
#[derive(Clone, Copy)]
pub(crate) struct PlateImage<'a> {
    samples: Samples<'a>,
    map: PixelMap,
    rectangle: Rectangle,
}

impl<'a> PlateImage<'a> {
    /// Creates the view of `image` through `map`, or `None` if the field has no row in the image.
    pub(crate) fn new(image: &'a Image, map: PixelMap) -> Option<Self> {
        Self::of_samples(image.samples(), map)
    }

    pub(crate) fn of_samples(samples: Samples<'a>, map: PixelMap) -> Option<Self> {
        let rectangle = map.rectangle(samples.bounds());
        (rectangle.pixel_count() > 0).then_some(Self {
            samples,
            map,
            rectangle,
        })
    }

    /// Number of channels.
    pub(crate) fn channels(&self) -> usize {
        self.samples.channels()
    }

    /// The pixels that exist.
    pub(crate) fn rectangle(&self) -> Rectangle {
        self.rectangle
    }

    /// Returns a sample, or `None` outside the image and its channels.
    pub(crate) fn get(&self, pixel: (i32, i32), channel: usize) -> Option<f32> {
        let (x, y) = self.map.frame_pixel(pixel.0, pixel.1);
        self.samples.get(x, y, channel)
    }

    /// Sets a sample of an output; does nothing outside the image and its channels.
    pub(crate) fn set(&self, pixel: (i32, i32), channel: usize, value: f32) {
        let (x, y) = self.map.frame_pixel(pixel.0, pixel.1);
        self.samples.set(x, y, channel, value);
    }

    /// Returns the pixel of the image that is nearest to `pixel`.
    pub(crate) fn nearest(&self, pixel: (i32, i32)) -> (i32, i32) {
        let (columns, rows) = (self.rectangle.columns(), self.rectangle.rows());
        (
            pixel.0.clamp(columns.start, columns.end - 1),
            pixel.1.clamp(rows.start, rows.end - 1),
        )
    }

    /// Returns the pixels of the image that lie in `rectangle`, row by row.
    pub(crate) fn pixels_in(
        &self,
        rectangle: Rectangle,
    ) -> impl Iterator<Item = (i32, i32)> + use<> {
        let shared = self.rectangle.intersection(&rectangle);
        shared.into_iter().flat_map(pixels_of)
    }

    /// Copies the pixels of `from` over `rectangle`; zero where it has none.
    pub(crate) fn copy(&self, from: &Self, rectangle: Rectangle) {
        for pixel in self.pixels_in(rectangle) {
            for channel in 0..self.channels() {
                self.set(pixel, channel, from.get(pixel, channel).unwrap_or(0.0));
            }
        }
    }

    /// Sets the pixels of `rectangle` that do not lie in `spared` to zero.
    pub(crate) fn clear_outside(&self, spared: Rectangle, rectangle: Rectangle) {
        for pixel in self.pixels_in(rectangle) {
            if !spared.contains(pixel.0, pixel.1) {
                for channel in 0..self.channels() {
                    self.set(pixel, channel, 0.0);
                }
            }
        }
    }
}

/// Returns the pixels of `rectangle`, row by row.
pub(crate) fn pixels_of(rectangle: Rectangle) -> impl Iterator<Item = (i32, i32)> {
    let pixels_of_row = move |y| rectangle.columns().map(move |x| (x, y));
    rectangle.rows().flat_map(pixels_of_row)
}

/// Returns a value for each pixel of `rectangle` and each of its `channels`, interleaved, row by row.
///
/// # Errors
/// Not enough memory.
pub(crate) fn collect_samples(
    rectangle: Rectangle,
    channels: usize,
    sample: impl Fn((i32, i32), usize) -> f32,
) -> Result<Vec<f32>> {
    let count = rectangle.pixel_count() * channels;
    let mut samples = Vec::new();
    samples.try_reserve_exact(count).map_err(|_| {
        Failure::memory(format!(
            "Not enough memory for {count} samples; render at a lower resolution."
        ))
    })?;
    for pixel in pixels_of(rectangle) {
        samples.extend((0..channels).map(|channel| sample(pixel, channel)));
    }
    Ok(samples)
}
