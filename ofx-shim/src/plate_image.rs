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

    /// Reads a channel of `pixel` and of those to its right, one a value; 0 where the image has no pixel.
    pub(crate) fn read_channel(&self, pixel: (i32, i32), channel: usize, values: &mut [f32]) {
        let Some(part) = self.shared(pixel, values.len()) else {
            values.fill(0.0);
            return;
        };
        values[..part.skipped].fill(0.0);
        values[part.skipped + part.count..].fill(0.0);
        let values = &mut values[part.skipped..part.skipped + part.count];
        self.samples.read_channel(part.x, part.y, channel, values);
    }

    /// Reads all channels of `pixel` and of those to its right, interleaved; 0 where the image has no pixel.
    pub(crate) fn read_pixels(&self, pixel: (i32, i32), values: &mut [f32]) {
        let channels = self.channels();
        let Some(part) = self.shared(pixel, values.len() / channels) else {
            values.fill(0.0);
            return;
        };
        let (start, end) = (part.skipped, part.skipped + part.count);
        values[..start * channels].fill(0.0);
        values[end * channels..].fill(0.0);
        let values = &mut values[start * channels..end * channels];
        self.samples.read_pixels(part.x, part.y, values);
    }

    /// Writes all channels of `pixel` of an output and of those to its right, interleaved, where the image has pixels.
    pub(crate) fn write_pixels(&self, pixel: (i32, i32), values: &[f32]) {
        let channels = self.channels();
        if let Some(part) = self.shared(pixel, values.len() / channels) {
            let (start, end) = (part.skipped, part.skipped + part.count);
            let values = &values[start * channels..end * channels];
            self.samples.write_pixels(part.x, part.y, values);
        }
    }

    /// Returns the part of `count` pixels from `pixel` on in its row that the image has.
    fn shared(&self, pixel: (i32, i32), count: usize) -> Option<RowPart> {
        let row = Rectangle {
            x: pixel.0,
            y: pixel.1,
            width: count,
            height: 1,
        };
        let shared = self.rectangle.intersection(&row)?;
        let (x, y) = self.map.frame_pixel(shared.x, shared.y);
        Some(RowPart {
            skipped: (shared.x - pixel.0) as usize,
            count: shared.width,
            x,
            y,
        })
    }

    /// Returns the pixel of the image that is nearest to `pixel`.
    pub(crate) fn nearest(&self, pixel: (i32, i32)) -> (i32, i32) {
        let (columns, rows) = (self.rectangle.columns(), self.rectangle.rows());
        (
            pixel.0.clamp(columns.start, columns.end - 1),
            pixel.1.clamp(rows.start, rows.end - 1),
        )
    }

    /// Copies the pixels of `from`, which has as many channels, over `rectangle`; zero where it has none.
    pub(crate) fn copy(&self, from: &Self, rectangle: Rectangle) {
        let mut row = vec![0.0; rectangle.width * self.channels()];
        for y in rectangle.rows() {
            from.read_pixels((rectangle.x, y), &mut row);
            self.write_pixels((rectangle.x, y), &row);
        }
    }

    /// Sets the pixels of `rectangle` that do not lie in `spared` to zero.
    pub(crate) fn clear_outside(&self, spared: Rectangle, rectangle: Rectangle) {
        let zeros = vec![0.0; rectangle.width * self.channels()];
        let columns = rectangle.columns();
        for y in rectangle.rows() {
            let clear = |from: i32, to: i32| {
                let count = (to - from).max(0) as usize * self.channels();
                self.write_pixels((from, y), &zeros[..count]);
            };
            if spared.rows().contains(&y) {
                clear(columns.start, columns.end.min(spared.columns().start));
                clear(columns.start.max(spared.columns().end), columns.end);
            } else {
                clear(columns.start, columns.end);
            }
        }
    }
}

/// Pixels side by side that an image has.
struct RowPart {
    /// Number of pixels asked for to the left of them.
    skipped: usize,
    count: usize,
    /// The first of them, as the host counts.
    x: i32,
    y: i32,
}

/// Returns the samples of the pixels of `rectangle`, which has so many `channels`, interleaved: each row as `read` fills it, from its
/// first pixel on. It is zero before.
///
/// # Errors
/// Not enough memory.
pub(crate) fn collect_rows(
    rectangle: Rectangle,
    channels: usize,
    mut read: impl FnMut((i32, i32), &mut [f32]),
) -> Result<Vec<f32>> {
    let count = rectangle.pixel_count() * channels;
    let mut samples = Vec::new();
    samples.try_reserve_exact(count).map_err(|_| {
        Failure::memory(format!(
            "Not enough memory for {count} samples; render at a lower resolution."
        ))
    })?;
    samples.resize(count, 0.0);
    if count > 0 {
        let rows = samples.chunks_exact_mut(rectangle.width * channels);
        for (y, row) in rectangle.rows().zip(rows) {
            read((rectangle.x, y), row);
        }
    }
    Ok(samples)
}
