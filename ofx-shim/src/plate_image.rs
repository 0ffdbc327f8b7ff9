//! Samples of pictures, pixel by pixel, for the little that is done beside the library.

use half::f16;
use seidel_c::{SEIDEL_HALF, SeidelImage, SeidelRect};

/// A picture whose samples can be read, or written if it is an output.
#[derive(Clone, Copy)]
pub(crate) struct Pixels {
    image: SeidelImage,
}

impl Pixels {
    /// Those of `image`.
    ///
    /// # Safety
    /// Its samples must stay good for as long as this is used.
    pub(crate) unsafe fn new(image: SeidelImage) -> Self {
        Self { image }
    }

    pub(crate) fn channels(&self) -> u32 {
        self.image.channels
    }

    /// The pixel nearest to a place.
    pub(crate) fn nearest(&self, (x, y): (i32, i32)) -> (i32, i32) {
        let rect = self.image.rect;
        let (right, bottom) = (rect.left + rect.width - 1, rect.top + rect.height - 1);
        (x.clamp(rect.left, right), y.clamp(rect.top, bottom))
    }

    /// The picture of `rect` alone, which must lie in it.
    pub(crate) fn part(&self, rect: SeidelRect) -> SeidelImage {
        let own = self.image.rect;
        let offset = i64::from(rect.top - own.top) * self.image.row_bytes
            + i64::from(rect.left - own.left) * i64::from(self.image.pixel_bytes);
        let first = self
            .image
            .data
            .cast::<u8>()
            .wrapping_offset(offset as isize);
        SeidelImage {
            data: first.cast(),
            rect,
            ..self.image
        }
    }

    /// The address of a sample, nothing where the picture has none.
    fn at(&self, (x, y): (i32, i32), channel: u32) -> Option<*mut u8> {
        let rect = self.image.rect;
        let (column, row) = (x - rect.left, y - rect.top);
        let inside = (0..rect.width).contains(&column) && (0..rect.height).contains(&row);
        if !inside || channel >= self.image.channels {
            return None;
        }
        let bytes = if self.is_half() { 2 } else { 4 };
        let offset = i64::from(row) * self.image.row_bytes
            + i64::from(column) * i64::from(self.image.pixel_bytes)
            + i64::from(channel * bytes);
        Some(
            self.image
                .data
                .cast::<u8>()
                .wrapping_offset(offset as isize),
        )
    }

    fn is_half(&self) -> bool {
        self.image.sample == SEIDEL_HALF
    }

    /// A sample; nothing beyond the picture and its channels.
    pub(crate) fn get(&self, place: (i32, i32), channel: u32) -> Option<f32> {
        let at = self.at(place, channel)?;
        Some(if self.is_half() {
            // SAFETY: within the picture, which its maker vouched for; at any address.
            f16::from_bits(unsafe { at.cast::<u16>().read_unaligned() }).to_f32()
        } else {
            // SAFETY: as above.
            unsafe { at.cast::<f32>().read_unaligned() }
        })
    }

    /// Sets a sample of an output; beyond it nothing.
    pub(crate) fn put(&self, place: (i32, i32), channel: u32, value: f32) {
        let Some(at) = self.at(place, channel) else {
            return;
        };
        if self.is_half() {
            // SAFETY: as above, of an output.
            unsafe {
                at.cast::<u16>()
                    .write_unaligned(f16::from_f32(value).to_bits())
            };
        } else {
            // SAFETY: as above.
            unsafe { at.cast::<f32>().write_unaligned(value) };
        }
    }

    /// Does `change` with every pixel of `rect` that there is.
    pub(crate) fn each(&self, rect: SeidelRect, mut change: impl FnMut(&Self, (i32, i32))) {
        let own = self.image.rect;
        let rows = rect.top.max(own.top)..(rect.top + rect.height).min(own.top + own.height);
        for y in rows {
            let columns =
                rect.left.max(own.left)..(rect.left + rect.width).min(own.left + own.width);
            for x in columns {
                change(self, (x, y));
            }
        }
    }

    /// Puts what `from` has over `rect`, zero where it has nothing.
    pub(crate) fn copy(&self, from: &Self, rect: SeidelRect) {
        self.each(rect, |to, place| {
            for channel in 0..to.channels() {
                to.put(place, channel, from.get(place, channel).unwrap_or(0.0));
            }
        });
    }

    /// Puts zero over `rect` but for what lies in `spared`.
    pub(crate) fn clear(&self, rect: SeidelRect, spared: SeidelRect) {
        let inside = |(x, y): (i32, i32)| {
            (spared.left..spared.left + spared.width).contains(&x)
                && (spared.top..spared.top + spared.height).contains(&y)
        };
        self.each(rect, |to, place| {
            if !inside(place) {
                (0..to.channels()).for_each(|channel| to.put(place, channel, 0.0));
            }
        });
    }
}
