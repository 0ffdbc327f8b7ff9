//! Image memory with guard bytes on all sides, which detects what plugins write where.

use std::collections::{BTreeMap, BTreeSet};
use std::mem::ManuallyDrop;

use super::profile::RowLayout;
use super::sample_type::SampleType;
use crate::picture::{Picture, Rect};

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
    samples: SampleType,
}

impl Layout {
    /// Returns the bytes of a pixel.
    fn pixel_bytes(&self) -> usize {
        self.samples.bytes() * self.channels
    }

    /// Returns the offset of a pixel, in bytes.
    fn offset(&self, x: i32, y: i32) -> usize {
        let row = i64::from(y - self.bounds.y1) * i64::from(self.row_bytes);
        let column = i64::from(x - self.bounds.x1) * self.pixel_bytes() as i64;
        usize::try_from(self.origin as i64 + row + column).unwrap_or(0)
    }
}

/// The memory of one image.
pub(crate) struct GuardedBuffer {
    memory: *mut u8,
    capacity: usize,
    layout: Layout,
    /// The bytes when the plugin got them.
    initial: Vec<u8>,
    /// The round of a render whose poison an output image has.
    round: u32,
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
    pub(crate) fn input(
        bounds: Rect,
        rows: RowLayout,
        samples: SampleType,
        picture: &Picture,
    ) -> Self {
        Self::new(bounds, picture.channels, rows, samples, |x, y, c| {
            samples.bits(picture.pixel(x, y).get(c).copied().unwrap_or(0.0))
        })
    }

    /// Creates an output image whose samples are poisoned as of that round, 0 or 1.
    pub(crate) fn output(
        bounds: Rect,
        channels: usize,
        rows: RowLayout,
        samples: SampleType,
        round: u32,
    ) -> Self {
        let poison = |x, y, c| samples.poison(x, y, c, round);
        let mut image = Self::new(bounds, channels, rows, samples, poison);
        image.round = round;
        image
    }

    fn new(
        bounds: Rect,
        channels: usize,
        rows: RowLayout,
        samples: SampleType,
        bits: impl Fn(i32, i32, usize) -> [u8; 4],
    ) -> Self {
        let (width, height) = (bounds.width(), bounds.height());
        let size = samples.bytes();
        let gap = match rows {
            RowLayout::Tight | RowLayout::Negative => 0,
            RowLayout::Padded => 64,
            RowLayout::Odd | RowLayout::NegativeOdd => size * (3 - width * channels % 2),
            RowLayout::Unaligned => 5,
        };
        let stride = width * channels * size + gap;
        let is_top_down = matches!(rows, RowLayout::Negative | RowLayout::NegativeOdd);
        let all = 2 * GUARD_BYTES + stride * height.max(1) + 16;
        let mut memory = Vec::with_capacity(all);
        memory.resize(all, GUARD_BYTE);
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
            samples,
        };
        for (x, y) in bounds.pixels() {
            let pixel = layout.offset(x, y);
            for c in 0..channels {
                let sample = pixel + size * c;
                memory[sample..sample + size].copy_from_slice(&bits(x, y, c)[..size]);
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
            round: 0,
        }
    }

    pub(crate) fn bounds(&self) -> Rect {
        self.layout.bounds
    }

    pub(crate) fn channels(&self) -> usize {
        self.layout.channels
    }

    pub(crate) fn samples(&self) -> SampleType {
        self.layout.samples
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
            let size = self.samples().bytes();
            let sample = self.layout.offset(x, y) + size * c;
            self.samples().value(&bytes[sample..sample + size])
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
        let (samples, pixel_bytes) = (self.samples(), self.layout.pixel_bytes());
        // Pixels by their offset, to find that of a byte.
        let mut pixels = BTreeMap::new();
        for (x, y) in self.bounds().pixels() {
            let offset = self.layout.offset(x, y);
            pixels.insert(offset, (x, y));
            if !expected(x, y) {
                continue;
            }
            let pixel = bytes[offset..offset + pixel_bytes].chunks_exact(samples.bytes());
            for (c, sample) in pixel.enumerate() {
                if *sample == samples.poison(x, y, c, self.round)[..samples.bytes()] {
                    found.unwritten.push((x, y, c));
                } else if !samples.value(sample).is_finite() {
                    found.not_finite.push((x, y));
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
    /// Samples of expected pixels that were not written, by x, y and channel.
    unwritten: Vec<(i32, i32, usize)>,
    /// Expected pixels with samples that are NaN or infinite.
    not_finite: Vec<(i32, i32)>,
    /// Other pixels that were written.
    outside: Vec<(i32, i32)>,
    /// Number of bytes written that belong to no pixel.
    guard_bytes: usize,
}

impl WrittenBytes {
    /// Returns whether samples seem not to be written.
    pub(crate) fn lacks_samples(&self) -> bool {
        !self.unwritten.is_empty()
    }

    /// Drops the samples that a render to another poison wrote.
    pub(crate) fn confirm_unwritten(&mut self, again: &Self) {
        let again: BTreeSet<_> = again.unwritten.iter().collect();
        self.unwritten.retain(|sample| again.contains(sample));
    }

    /// Describes all faults.
    pub(crate) fn faults(&self) -> Vec<String> {
        let unwritten: Vec<_> = self.unwritten.iter().map(|(x, y, _)| (*x, *y)).collect();
        let expected = [
            ("not written", &unwritten),
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
    let count = pixels.iter().collect::<BTreeSet<_>>().len();
    Some(format!("{count} pixels {what}, the first at {first:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unwritten_and_stray_pixels_are_found() {
        for rows in RowLayout::ALIGNED {
            let bounds = Rect::new(-2, 3, 5, 8);
            let buffer = GuardedBuffer::output(bounds, 4, rows, SampleType::Float, 0);
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
        let buffer =
            |channels, rows| GuardedBuffer::output(bounds, channels, rows, SampleType::Float, 0);
        assert_eq!(buffer(4, RowLayout::Tight).row_bytes(), 48);
        assert_eq!(buffer(4, RowLayout::Negative).row_bytes(), -48);
        let odd = buffer(3, RowLayout::Odd).row_bytes();
        assert!(odd % 4 == 0 && odd / 4 % 2 == 1);
        assert_ne!(buffer(4, RowLayout::Unaligned).row_bytes() % 4, 0);
        assert_eq!(buffer(4, RowLayout::Tight).data() % 16, 0);
        let bytes = GuardedBuffer::output(bounds, 3, RowLayout::Odd, SampleType::Byte, 0);
        assert_eq!((bytes.row_bytes() - 9) % 2, 0);
    }

    #[test]
    fn a_second_poison_tells_unwritten_bytes_from_equal_ones() {
        let bounds = Rect::new(0, 0, 8, 4);
        let of_round = |round| {
            let buffer =
                GuardedBuffer::output(bounds, 1, RowLayout::Padded, SampleType::Byte, round);
            // Every pixel but one gets the poison of the first round.
            for (x, y) in bounds.pixels().filter(|pixel| *pixel != (5, 2)) {
                let value = SampleType::Byte.poison(x, y, 0, 0)[0];
                // SAFETY: inside the buffer.
                unsafe { buffer.memory.add(buffer.layout.offset(x, y)).write(value) };
            }
            buffer.written(|_, _| true)
        };
        let mut first = of_round(0);
        assert_eq!(first.unwritten.len(), 32);
        first.confirm_unwritten(&of_round(1));
        assert_eq!(first.unwritten, [(5, 2, 0)]);
    }
}
