//! Pictures as hosts keep them: any order of rows, any room between them, at any address, half and single.

use std::ptr::null;

use half::f16;
use seidel_c::*;

use crate::support::{Held, Picture, applied, doors, farthest, plate, rect, settings, well};

const AREA: SeidelRect = SeidelRect {
    left: -3,
    top: 5,
    width: 50,
    height: 34,
};

/// A picture in bytes: rows `row_bytes` apart, from the bottom up if that is negative, `lead` bytes before all.
struct Stored {
    bytes: Vec<u8>,
    row_bytes: i64,
    pixel_bytes: usize,
    half: bool,
    lead: usize,
    channels: usize,
}

const CANARY: u8 = 0xc5;

impl Stored {
    fn new(picture: &Picture, (row_bytes, pixel_bytes): (i64, usize), half: bool) -> Self {
        // An odd address.
        let lead = 129;
        let rows = picture.rect.height as usize;
        let mut stored = Self {
            bytes: vec![CANARY; lead + row_bytes.unsigned_abs() as usize * rows + 64],
            row_bytes,
            pixel_bytes,
            half,
            lead,
            channels: picture.channels,
        };
        for (k, sample) in picture.samples.iter().enumerate() {
            let at = stored.at(k, picture.rect);
            match half {
                true => stored.bytes[at..at + 2]
                    .copy_from_slice(&f16::from_f32(*sample).to_bits().to_ne_bytes()),
                false => stored.bytes[at..at + 4].copy_from_slice(&sample.to_ne_bytes()),
            }
        }
        stored
    }

    /// Where the first row begins.
    fn first(&self, rect: SeidelRect) -> usize {
        let last = (rect.height - 1) as usize * self.row_bytes.unsigned_abs() as usize;
        self.lead + if self.row_bytes < 0 { last } else { 0 }
    }

    /// Where sample `k` lies.
    fn at(&self, k: usize, rect: SeidelRect) -> usize {
        let (pixel, channel) = (k / self.channels, k % self.channels);
        let (column, row) = (pixel % rect.width as usize, pixel / rect.width as usize);
        let start = self.first(rect) as i64 + row as i64 * self.row_bytes;
        start as usize + column * self.pixel_bytes + channel * if self.half { 2 } else { 4 }
    }

    fn image(&mut self, rect: SeidelRect) -> SeidelImage {
        let first = self.first(rect);
        SeidelImage {
            size: size_of::<SeidelImage>() as u64,
            data: self.bytes[first..].as_mut_ptr().cast(),
            row_bytes: self.row_bytes,
            pixel_bytes: self.pixel_bytes as u32,
            channels: self.channels as u32,
            sample: if self.half { SEIDEL_HALF } else { SEIDEL_FLOAT },
            reserved: 0,
            rect,
        }
    }

    fn samples(&self, rect: SeidelRect) -> Vec<f32> {
        let count = (rect.width * rect.height) as usize * self.channels;
        let one = |k: usize| {
            let at = self.at(k, rect);
            let bytes = &self.bytes[at..];
            match self.half {
                true => f16::from_bits(u16::from_ne_bytes([bytes[0], bytes[1]])).to_f32(),
                false => f32::from_ne_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            }
        };
        (0..count).map(one).collect()
    }

    /// Whether all but the samples is as it was.
    fn is_untouched_between(&self, rect: SeidelRect) -> bool {
        let mut free = vec![true; self.bytes.len()];
        let bytes = if self.half { 2 } else { 4 };
        for k in 0..(rect.width * rect.height) as usize * self.channels {
            let at = self.at(k, rect);
            free[at..at + bytes].fill(false);
        }
        let kept = self.bytes.iter().zip(free);
        kept.filter(|(_, free)| *free)
            .all(|(byte, _)| *byte == CANARY)
    }
}

#[test]
fn rows_may_be_padded_reversed_and_at_any_address() {
    let lens = Held::new(2.0);
    let source = Picture::busy(AREA, 4);
    let settings = settings();
    let image = source.image();
    let want = applied(&lens, &settings, &plate(&image, AREA), AREA);
    for (layout, half) in [
        ((50 * 16 + 7, 16), false),
        ((-(50 * 16 + 3), 16), false),
        ((50 * 21, 21), false),
        ((50 * 8 + 1, 8), true),
        ((-50 * 8, 8), true),
    ] {
        let mut stored = Stored::new(&source, layout, half);
        let mut out = Stored::new(&Picture::black(AREA, 4), layout, half);
        let (image, output) = (stored.image(AREA), out.image(AREA));
        let plate = plate(&image, AREA);
        // SAFETY: all pointers are good.
        well(unsafe { (doors().apply)(lens.0, &settings, &plate, &output, null(), null()) });
        let (got, before) = (out.samples(AREA), stored.samples(AREA));
        if half {
            let rounded: Vec<f32> = want
                .samples
                .iter()
                .map(|v| f16::from_f32(*v).to_f32())
                .collect();
            // The source was rounded as well: a part in 2048 of at most 42.
            assert!(farthest(&got, &rounded) < 0.03, "{layout:?}");
            let off = got
                .iter()
                .zip(&rounded)
                .filter(|(a, b)| (*a - *b).abs() > 2e-3 * b.abs());
            assert!(off.count() * 20 < got.len(), "{layout:?}");
        } else {
            assert_eq!(got, want.samples, "{layout:?}");
            assert_eq!(before, source.samples);
        }
        assert!(out.is_untouched_between(AREA), "{layout:?}");
        assert!(stored.is_untouched_between(AREA), "{layout:?}");
    }
}

#[test]
fn a_plate_that_stays_as_it_is_does_so_to_the_bit_also_in_halves() {
    let lens = Held::new(2.0);
    let mut source = Picture::busy(AREA, 3);
    source.samples[5] = -0.0;
    source.samples[6] = 6e-8;
    let mut settings = settings();
    settings.amount = 0.0;
    let mut stored = Stored::new(&source, (-50 * 6, 6), true);
    let mut out = Stored::new(&Picture::black(AREA, 3), (-50 * 6, 6), true);
    let (image, output) = (stored.image(AREA), out.image(AREA));
    let plate = plate(&image, AREA);
    // SAFETY: all pointers are good.
    well(unsafe { (doors().apply)(lens.0, &settings, &plate, &output, null(), null()) });
    assert_eq!(out.bytes, stored.bytes);
}

#[test]
fn results_may_take_the_place_of_the_source_and_one_channel_be_taken_out_of_many() {
    let lens = Held::new(2.0);
    let source = Picture::busy(AREA, 4);
    let settings = settings();
    let image = source.image();
    let want = applied(&lens, &settings, &plate(&image, AREA), AREA);
    let mut own = source.clone();
    let image = own.output();
    // SAFETY: all pointers are good; source and output are the same memory.
    well(unsafe {
        (doors().apply)(
            lens.0,
            &settings,
            &plate(&image, AREA),
            &image,
            null(),
            null(),
        )
    });
    assert_eq!(own.bits(), want.bits());
    // Depth in the third channel of a picture, against the same alone.
    let near = |x: i32| if x < 20 { 1.4 } else { 6.0 };
    let alone = Picture::of(AREA, 1, |x, _, _| near(x));
    let among = Picture::of(AREA, 4, |x, _, c| if c == 2 { near(x) } else { -1.0 });
    let [alone, among] = [alone.image(), among.image()];
    let third = SeidelImage {
        data: among.data.cast::<u8>().wrapping_add(8).cast(),
        pixel_bytes: 16,
        channels: 1,
        ..among
    };
    let source_image = source.image();
    let results = [&alone, &third].map(|depth| {
        let mut plate = plate(&source_image, AREA);
        plate.depth = depth;
        applied(&lens, &settings, &plate, AREA)
    });
    assert_eq!(results[0].bits(), results[1].bits());
    assert_ne!(results[0].bits(), want.bits());
}

#[test]
fn one_to_four_channels_mean_what_the_header_says() {
    let lens = Held::new(3.0);
    let mut settings = settings();
    settings.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED;
    let four = Picture::busy(AREA, 4);
    let image = four.image();
    let all = applied(&lens, &settings, &plate(&image, AREA), AREA);
    // Two channels: grey and alpha, blurred by all channels of the lens alike.
    let two = Picture::of(AREA, 2, |x, y, c| {
        let at = ((y - AREA.top) * AREA.width + x - AREA.left) as usize * 4;
        four.samples[at + [0, 3][c]]
    });
    let image = two.image();
    let grey = applied(&lens, &settings, &plate(&image, AREA), AREA);
    assert!(farthest(&grey.plane(1), &all.plane(3)) < 1e-6);
    // Unpremultiplied colour of an even grey stays even where alpha does not.
    let even = Picture::of(AREA, 2, |x, _, c| {
        if c == 0 {
            0.5
        } else {
            f32::from(u8::from(x > 20))
        }
    });
    let image = even.image();
    let result = applied(&lens, &settings, &plate(&image, AREA), AREA);
    let covered = result
        .samples
        .chunks_exact(2)
        .filter(|pixel| pixel[1] > 1e-3);
    assert!(covered.clone().count() > 700 && covered.clone().any(|pixel| pixel[1] < 0.9));
    assert!(covered.clone().all(|pixel| (pixel[0] - 0.5).abs() < 1e-3));
    // Three and one: no alpha.
    for channels in [1, 3] {
        let picture = Picture::busy(rect(0, 0, 40, 30), channels);
        let image = picture.image();
        let plate = plate(&image, picture.rect);
        let result = applied(&lens, &settings, &plate, picture.rect);
        let sum = |p: &Picture| p.samples.iter().map(|v| f64::from(*v)).sum::<f64>();
        assert!((sum(&result) / sum(&picture) - 1.0).abs() < 2e-3);
        assert_ne!(result.bits(), picture.bits());
    }
}
