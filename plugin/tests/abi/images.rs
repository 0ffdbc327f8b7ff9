//! Layouts of images in memory: order of rows, padding, alignment, sample formats, number of channels.

use std::ptr::null;

use half::f16;
use seidel_c::*;

use crate::support::{
    LensHandle, TestImage, apply, assert_ok, assert_refused, exports, max_difference, plate, rect,
    settings,
};

const AREA: SeidelRect = SeidelRect {
    left: -3,
    top: 5,
    width: 50,
    height: 34,
};

/// Bytes before the first row: an odd number, so that samples are not aligned.
const LEAD: usize = 129;

/// Value of the bytes between samples.
const PADDING: u8 = 0xc5;

#[derive(Debug, Clone, Copy)]
struct Layout {
    /// Bytes from a row to the one below it; negative if rows are stored from the bottom up.
    row_bytes: i64,
    pixel_bytes: usize,
    /// SEIDEL_HALF or SEIDEL_FLOAT.
    sample: u32,
}

impl Layout {
    fn sample_bytes(self) -> usize {
        if self.sample == SEIDEL_HALF { 2 } else { 4 }
    }
}

/// An image in bytes with a given layout.
struct StoredImage {
    bytes: Vec<u8>,
    layout: Layout,
    rect: SeidelRect,
    channels: usize,
}

impl StoredImage {
    fn new(image: &TestImage, layout: Layout) -> Self {
        let rows = image.rect.height as usize;
        let mut stored = Self {
            bytes: vec![PADDING; LEAD + layout.row_bytes.unsigned_abs() as usize * rows + 64],
            layout,
            rect: image.rect,
            channels: image.channels,
        };
        for (k, sample) in image.samples.iter().enumerate() {
            let at = stored.offset(k);
            if layout.sample == SEIDEL_HALF {
                let bits = f16::from_f32(*sample).to_bits();
                stored.bytes[at..at + 2].copy_from_slice(&bits.to_ne_bytes());
            } else {
                stored.bytes[at..at + 4].copy_from_slice(&sample.to_ne_bytes());
            }
        }
        stored
    }

    /// Returns the offset of the top row.
    fn top_row(&self) -> usize {
        let row_bytes = self.layout.row_bytes;
        let last = (self.rect.height - 1) as usize * row_bytes.unsigned_abs() as usize;
        LEAD + if row_bytes < 0 { last } else { 0 }
    }

    /// Returns the offset of sample `k`, counted as in a packed image.
    fn offset(&self, k: usize) -> usize {
        let (pixel, channel) = (k / self.channels, k % self.channels);
        let width = self.rect.width as usize;
        let (column, row) = (pixel % width, pixel / width);
        let start = self.top_row() as i64 + row as i64 * self.layout.row_bytes;
        start as usize + column * self.layout.pixel_bytes + channel * self.layout.sample_bytes()
    }

    fn sample_count(&self) -> usize {
        (self.rect.width * self.rect.height) as usize * self.channels
    }

    fn image(&mut self) -> SeidelImage {
        let top_row = self.top_row();
        SeidelImage {
            size: size_of::<SeidelImage>() as u64,
            data: self.bytes[top_row..].as_mut_ptr().cast(),
            row_bytes: self.layout.row_bytes,
            pixel_bytes: self.layout.pixel_bytes as u32,
            channels: self.channels as u32,
            sample: self.layout.sample,
            reserved: 0,
            rect: self.rect,
        }
    }

    fn samples(&self) -> Vec<f32> {
        let sample = |k: usize| {
            let bytes = &self.bytes[self.offset(k)..];
            if self.layout.sample == SEIDEL_HALF {
                f16::from_bits(u16::from_ne_bytes([bytes[0], bytes[1]])).to_f32()
            } else {
                f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
            }
        };
        (0..self.sample_count()).map(sample).collect()
    }

    /// Returns whether all bytes between samples still have their value.
    fn is_padding_untouched(&self) -> bool {
        let mut is_padding = vec![true; self.bytes.len()];
        for k in 0..self.sample_count() {
            let at = self.offset(k);
            is_padding[at..at + self.layout.sample_bytes()].fill(false);
        }
        let mut padding = (self.bytes.iter().zip(is_padding)).filter(|(_, is_padding)| *is_padding);
        padding.all(|(byte, _)| *byte == PADDING)
    }
}

#[test]
fn a_result_beyond_half_floats_is_refused_and_nothing_is_written() {
    let lens = LensHandle::new(2.0);
    let mut source = TestImage::pattern(AREA, 4);
    source.samples.fill(1e6);
    let input = source.input();
    let layout = Layout {
        row_bytes: 50 * 8,
        pixel_bytes: 8,
        sample: SEIDEL_HALF,
    };
    let mut out = StoredImage::new(&TestImage::black(AREA, 4), layout);
    let output = out.image();
    let plate = plate(&input, AREA);
    for amount in [0.0, 1.0] {
        let mut settings = settings();
        settings.amount = amount;
        // SAFETY: all pointers are valid.
        let status =
            unsafe { (exports().apply)(lens.0, &settings, &plate, &output, null(), null()) };
        assert_refused(
            status,
            SeidelStatus::Argument,
            "beyond the largest half float",
        );
    }
    assert!(out.samples().iter().all(|sample| *sample == 0.0));
}

#[test]
fn rows_may_be_padded_reversed_and_unaligned() {
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(AREA, 4);
    let settings = settings();
    let input = source.input();
    let want = apply(&lens, &settings, &plate(&input, AREA), AREA);
    for (row_bytes, pixel_bytes, sample) in [
        (50 * 16 + 7, 16, SEIDEL_FLOAT),
        (-(50 * 16 + 3), 16, SEIDEL_FLOAT),
        (50 * 21, 21, SEIDEL_FLOAT),
        (50 * 8 + 1, 8, SEIDEL_HALF),
        (-50 * 8, 8, SEIDEL_HALF),
    ] {
        let layout = Layout {
            row_bytes,
            pixel_bytes,
            sample,
        };
        let mut stored = StoredImage::new(&source, layout);
        let mut out = StoredImage::new(&TestImage::black(AREA, 4), layout);
        let (input, output) = (stored.image(), out.image());
        let plate = plate(&input, AREA);
        // SAFETY: all pointers are valid.
        assert_ok(unsafe { (exports().apply)(lens.0, &settings, &plate, &output, null(), null()) });
        let got = out.samples();
        if sample == SEIDEL_HALF {
            let want = want.samples.iter().map(|v| f16::from_f32(*v).to_f32());
            let want: Vec<f32> = want.collect();
            // Source and result were rounded: lamps, of at most 42, by half a step of 1/32 each.
            assert!(max_difference(&got, &want) <= 1.0 / 32.0, "{layout:?}");
            let differing =
                (got.iter().zip(&want)).filter(|(a, b)| (*a - *b).abs() > 2e-3 * b.abs());
            assert!(differing.count() * 20 < got.len(), "{layout:?}");
        } else {
            assert_eq!(got, want.samples, "{layout:?}");
            assert_eq!(stored.samples(), source.samples, "{layout:?}");
        }
        assert!(out.is_padding_untouched(), "{layout:?}");
        assert!(stored.is_padding_untouched(), "{layout:?}");
    }
}

#[test]
fn a_source_beside_the_extent_counts_as_black() {
    let lens = LensHandle::new(2.0);
    for (left, top) in [(60, 5), (-90, 5), (-3, 50), (60, 50), (-90, -70)] {
        let source = TestImage::pattern(rect(left, top, 50, 34), 4);
        let input = source.input();
        let out = apply(&lens, &settings(), &plate(&input, AREA), AREA);
        assert!(out.samples.iter().all(|v| *v == 0.0), "({left}, {top})");
    }
}

#[test]
fn an_amount_of_zero_copies_half_samples_bit_for_bit() {
    let lens = LensHandle::new(2.0);
    let mut source = TestImage::pattern(AREA, 3);
    source.samples[5] = -0.0;
    source.samples[6] = 6e-8;
    let mut settings = settings();
    settings.amount = 0.0;
    let layout = Layout {
        row_bytes: -50 * 6,
        pixel_bytes: 6,
        sample: SEIDEL_HALF,
    };
    let mut stored = StoredImage::new(&source, layout);
    let mut out = StoredImage::new(&TestImage::black(AREA, 3), layout);
    let (input, output) = (stored.image(), out.image());
    let plate = plate(&input, AREA);
    // SAFETY: all pointers are valid.
    assert_ok(unsafe { (exports().apply)(lens.0, &settings, &plate, &output, null(), null()) });
    assert_eq!(out.bytes, stored.bytes);
}

#[test]
fn the_output_may_be_the_memory_of_the_source() {
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(AREA, 4);
    let settings = settings();
    let input = source.input();
    let want = apply(&lens, &settings, &plate(&input, AREA), AREA);
    let mut shared = source.clone();
    let image = shared.output();
    let plate = plate(&image, AREA);
    // SAFETY: all pointers are valid; source and output are the same memory.
    assert_ok(unsafe { (exports().apply)(lens.0, &settings, &plate, &image, null(), null()) });
    assert_eq!(shared.bits(), want.bits());
}

#[test]
fn depth_may_be_one_channel_of_many() {
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(AREA, 4);
    let settings = settings();
    let input = source.input();
    let without_depth = apply(&lens, &settings, &plate(&input, AREA), AREA);
    let metres = |x: i32| if x < 20 { 1.4 } else { 6.0 };
    let alone = TestImage::from_fn(AREA, 1, |x, _, _| metres(x));
    let third = TestImage::from_fn(AREA, 4, |x, _, c| if c == 2 { metres(x) } else { -1.0 });
    let all_channels = third.input();
    let third_channel = SeidelImage {
        data: all_channels.data.cast::<u8>().wrapping_add(8).cast(),
        pixel_bytes: 16,
        channels: 1,
        ..all_channels
    };
    let results = [&alone.input(), &third_channel].map(|depth| {
        let mut plate = plate(&input, AREA);
        plate.depth = depth;
        apply(&lens, &settings, &plate, AREA)
    });
    assert_eq!(results[0].bits(), results[1].bits());
    assert_ne!(results[0].bits(), without_depth.bits());
}

#[test]
fn the_number_of_channels_has_the_meaning_that_the_header_states() {
    let lens = LensHandle::new(3.0);
    let mut settings = settings();
    settings.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED;
    let four = TestImage::pattern(AREA, 4);
    let input = four.input();
    let all = apply(&lens, &settings, &plate(&input, AREA), AREA);
    // Two channels, Y and A: all channels of the lens contribute equally.
    let two = TestImage::from_fn(AREA, 2, |x, y, c| {
        let at = ((y - AREA.top) * AREA.width + x - AREA.left) as usize * 4;
        four.samples[at + [0, 3][c]]
    });
    let input = two.input();
    let grey = apply(&lens, &settings, &plate(&input, AREA), AREA);
    assert!(max_difference(&grey.plane(1), &all.plane(3)) < 1e-6);
    // A uniform unpremultiplied grey remains uniform across an edge of alpha.
    let uniform = TestImage::from_fn(AREA, 2, |x, _, c| {
        if c == 0 {
            0.5
        } else {
            f32::from(u8::from(x > 20))
        }
    });
    let input = uniform.input();
    let result = apply(&lens, &settings, &plate(&input, AREA), AREA);
    let pixels = result.samples.chunks_exact(2);
    let covered: Vec<_> = pixels.filter(|pixel| pixel[1] > 1e-3).collect();
    assert!(covered.len() > 700 && covered.iter().any(|pixel| pixel[1] < 0.9));
    assert!(covered.iter().all(|pixel| (pixel[0] - 0.5).abs() < 1e-3));
    // One and three channels, Y and RGB: no alpha.
    for channels in [1, 3] {
        let source = TestImage::pattern(rect(0, 0, 40, 30), channels);
        let input = source.input();
        let plate = plate(&input, source.rect);
        let result = apply(&lens, &settings, &plate, source.rect);
        let sum = |p: &TestImage| p.samples.iter().map(|v| f64::from(*v)).sum::<f64>();
        assert!((sum(&result) / sum(&source) - 1.0).abs() < 2e-3);
        assert_ne!(result.bits(), source.bits());
    }
}
