//! Image memory with guard bytes on all sides, which detects what plugins write where.

use std::collections::BTreeMap;
use std::mem::ManuallyDrop;

use super::profile::RowLayout;
use crate::picture::{Picture, Rect};

/// The initial bits of output samples: a quiet NaN that no arithmetic produces.
const POISON: u32 = 0x7fc0_dead;
/// The initial value of bytes that belong to no pixel.
const GUARD_BYTE: u8 = 0xa5;
/// The number of guard bytes before and after an image.
const GUARD_BYTES: usize = 4096;

/// The layout of an image's pixels in its memory.
#[derive(Clone, Copy)]
struct Layout {
    /// Offset of the lower left pixel, in bytes.
    origin: usize,
    row_bytes: i32,
    bounds: Rect,
    channels: usize,
}

impl Layout {
    /// Returns the offset of a pixel, in bytes.
    fn offset(&self, x: i32, y: i32) -> usize {
        let row = i64::from(y - self.bounds.y1) * i64::from(self.row_bytes);
        let column = i64::from(x - self.bounds.x1) * 4 * self.channels as i64;
        usize::try_from(self.origin as i64 + row + column).unwrap_or(0)
    }
}

/// The memory of one float image.
pub(crate) struct GuardedBuffer {
    memory: *mut u8,
    capacity: usize,
    layout: Layout,
    /// The bytes when the plugin got them.
    initial: Vec<u8>,
}

// SAFETY: the host accesses the memory by copying bytes only, and plugins expect no more than raw memory.
unsafe impl Send for GuardedBuffer {}
// SAFETY: as above.
unsafe impl Sync for GuardedBuffer {}

impl Drop for GuardedBuffer {
    fn drop(&mut self) {
        // SAFETY: the memory is that of a vector of this length and capacity, and is freed here only.
        drop(unsafe { Vec::from_raw_parts(self.memory, self.capacity, self.capacity) });
    }
}

impl GuardedBuffer {
    /// Creates an input image with the samples of `picture`, 0 outside it.
    pub(crate) fn input(bounds: Rect, rows: RowLayout, picture: &Picture) -> Self {
        Self::new(bounds, picture.channels, rows, |x, y, c| {
            picture.pixel(x, y).get(c).copied().unwrap_or(0.0).to_bits()
        })
    }

    /// Creates an output image whose samples are poisoned.
    pub(crate) fn output(bounds: Rect, channels: usize, rows: RowLayout) -> Self {
        Self::new(bounds, channels, rows, |_, _, _| POISON)
    }

    fn new(
        bounds: Rect,
        channels: usize,
        rows: RowLayout,
        bits: impl Fn(i32, i32, usize) -> u32,
    ) -> Self {
        let (width, height) = (bounds.width(), bounds.height());
        let gap = match rows {
            RowLayout::Tight | RowLayout::Negative => 0,
            RowLayout::Padded => 64,
            RowLayout::Odd | RowLayout::NegativeOdd => 4 * (3 - width * channels % 2),
            RowLayout::Unaligned => 5,
        };
        let stride = width * channels * 4 + gap;
        let is_top_down = matches!(rows, RowLayout::Negative | RowLayout::NegativeOdd);
        let size = 2 * GUARD_BYTES + stride * height.max(1) + 16;
        let mut memory = Vec::with_capacity(size);
        memory.resize(size, GUARD_BYTE);
        memory.shrink_to_fit();
        // Hosts align images to 16 bytes.
        let start = GUARD_BYTES + memory.as_ptr().align_offset(16);
        let row_bytes = i32::try_from(stride).unwrap_or(i32::MAX);
        let layout = Layout {
            origin: if is_top_down {
                start + stride * height.saturating_sub(1)
            } else {
                start
            },
            row_bytes: if is_top_down { -row_bytes } else { row_bytes },
            bounds,
            channels,
        };
        for (x, y) in bounds.pixels() {
            let pixel = layout.offset(x, y);
            for c in 0..channels {
                let sample = pixel + 4 * c;
                memory[sample..sample + 4].copy_from_slice(&bits(x, y, c).to_ne_bytes());
            }
        }
        let initial = memory.clone();
        let capacity = memory.capacity();
        memory.resize(capacity, GUARD_BYTE);
        let mut memory = ManuallyDrop::new(memory);
        Self {
            memory: memory.as_mut_ptr(),
            capacity,
            layout,
            initial,
        }
    }

    pub(crate) fn bounds(&self) -> Rect {
        self.layout.bounds
    }

    pub(crate) fn channels(&self) -> usize {
        self.layout.channels
    }

    pub(crate) fn row_bytes(&self) -> i32 {
        self.layout.row_bytes
    }

    /// Returns the address of the lower left pixel.
    pub(crate) fn data(&self) -> usize {
        self.memory as usize + self.layout.origin
    }

    /// Returns a copy of all bytes.
    fn bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.initial.len()];
        // SAFETY: the memory has as many bytes, and nobody writes to it because the action has returned.
        unsafe {
            self.memory
                .copy_to_nonoverlapping(bytes.as_mut_ptr(), bytes.len())
        };
        bytes
    }

    /// Overwrites every byte, so that later reads give NaN.
    pub(crate) fn overwrite(&self) {
        // SAFETY: the memory has as many bytes, and the plugin has released it.
        unsafe { self.memory.write_bytes(0xff, self.initial.len()) };
    }

    /// Returns the image as a picture.
    pub(crate) fn picture(&self) -> Picture {
        let bytes = self.bytes();
        Picture::from_fn(self.bounds(), self.channels(), |x, y, c| {
            let sample = self.layout.offset(x, y) + 4 * c;
            let mut four = [0; 4];
            four.copy_from_slice(&bytes[sample..sample + 4]);
            f32::from_ne_bytes(four)
        })
    }

    /// Returns whether any byte has changed.
    pub(crate) fn has_changed(&self) -> bool {
        self.bytes() != self.initial
    }

    /// Compares the bytes with the initial ones. The plugin should have written exactly the pixels of `expected`.
    pub(crate) fn written(&self, expected: impl Fn(i32, i32) -> bool) -> WrittenBytes {
        let bytes = self.bytes();
        let mut found = WrittenBytes::default();
        let pixel_bytes = 4 * self.channels();
        // Pixels by their offset, to find that of a byte.
        let mut pixels = BTreeMap::new();
        for (x, y) in self.bounds().pixels() {
            let offset = self.layout.offset(x, y);
            pixels.insert(offset, (x, y));
            if !expected(x, y) {
                continue;
            }
            let samples = bytes[offset..offset + pixel_bytes].as_chunks::<4>().0;
            for bits in samples.iter().map(|sample| u32::from_ne_bytes(*sample)) {
                if bits == POISON {
                    found.unwritten.push((x, y));
                    break;
                }
                if !f32::from_bits(bits).is_finite() {
                    found.not_finite.push((x, y));
                    break;
                }
            }
        }
        for i in (0..bytes.len()).filter(|i| bytes[*i] != self.initial[*i]) {
            match pixels.range(..=i).next_back() {
                Some((offset, (x, y))) if i < offset + pixel_bytes => {
                    if !expected(*x, *y) && found.outside.last() != Some(&(*x, *y)) {
                        found.outside.push((*x, *y));
                    }
                }
                _ => found.guard_bytes += 1,
            }
        }
        found
    }
}

/// Differences between the bytes of an output image and those that should have been written.
#[derive(Default)]
pub(crate) struct WrittenBytes {
    /// Expected pixels with samples that were not written.
    unwritten: Vec<(i32, i32)>,
    /// Expected pixels with samples that are NaN or infinite.
    not_finite: Vec<(i32, i32)>,
    /// Other pixels that were written.
    outside: Vec<(i32, i32)>,
    /// Number of bytes written that belong to no pixel.
    guard_bytes: usize,
}

impl WrittenBytes {
    /// Describes all faults.
    pub(crate) fn faults(&self) -> Vec<String> {
        let expected = [
            ("not written", &self.unwritten),
            ("written with values that are not finite", &self.not_finite),
        ];
        let mut faults: Vec<String> = (expected.iter())
            .filter_map(|(what, pixels)| pixel_fault(what, pixels))
            .collect();
        faults.extend(self.faults_outside());
        faults
    }

    /// Describes what was written outside the expected pixels.
    pub(crate) fn faults_outside(&self) -> Vec<String> {
        let outside = pixel_fault("written outside the render window", &self.outside);
        let guard = (self.guard_bytes > 0)
            .then(|| format!("{} bytes written that belong to no pixel", self.guard_bytes));
        outside.into_iter().chain(guard).collect()
    }
}

fn pixel_fault(what: &str, pixels: &[(i32, i32)]) -> Option<String> {
    let first = pixels.first()?;
    Some(format!(
        "{} pixels {what}, the first at {first:?}",
        pixels.len()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unwritten_and_stray_pixels_are_found() {
        for rows in RowLayout::ALIGNED {
            let bounds = Rect::new(-2, 3, 5, 8);
            let buffer = GuardedBuffer::output(bounds, 4, rows);
            let write = |x: i32, y: i32, value: f32| {
                let offset = buffer.layout.offset(x, y);
                for c in 0..4 {
                    // SAFETY: inside the buffer, guards included.
                    unsafe {
                        buffer
                            .memory
                            .add(offset + 4 * c)
                            .cast::<f32>()
                            .write_unaligned(value)
                    };
                }
            };
            let window = Rect::new(-2, 3, 5, 7);
            let faults = || buffer.written(|x, y| window.contains(x, y)).faults();
            assert!(faults()[0].starts_with("28 pixels not written"));
            for (x, y) in window.pixels() {
                write(x, y, 0.5);
            }
            assert!(faults().is_empty(), "{rows:?}");
            write(0, 4, f32::INFINITY);
            write(1, 7, 0.5);
            let found = faults();
            assert!(found[0].contains("not finite") && found[0].contains("(0, 4)"));
            assert!(found[1].contains("outside") && found[1].contains("(1, 7)"));
            write(-2, 9, 0.5);
            let found = faults();
            assert!(found.len() == 3, "{rows:?}: {found:?}");
            assert_eq!(buffer.picture().pixel(3, 5), &[0.5; 4]);
        }
    }

    #[test]
    fn row_bytes_follow_the_layout() {
        let bounds = Rect::new(0, 0, 3, 2);
        let buffer = |channels, rows| GuardedBuffer::output(bounds, channels, rows);
        assert_eq!(buffer(4, RowLayout::Tight).row_bytes(), 48);
        assert_eq!(buffer(4, RowLayout::Negative).row_bytes(), -48);
        let odd = buffer(3, RowLayout::Odd).row_bytes();
        assert!(odd % 4 == 0 && odd / 4 % 2 == 1);
        assert_ne!(buffer(4, RowLayout::Unaligned).row_bytes() % 4, 0);
        assert_eq!(buffer(4, RowLayout::Tight).data() % 16, 0);
    }
}
