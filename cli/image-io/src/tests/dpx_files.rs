//! DPX files, which the tests lay out byte by byte: round trips, and files that are refused.

use std::fs;
use std::path::Path;

use crate::formats::dpx::byte_order::ByteOrder;
use crate::plate::{PlateFile, PlateOptions};
use crate::raster::RasterImage;
use crate::samples::{Encoding, SampleFormat};

/// A builder of DPX files.
pub(crate) struct DpxBuilder {
    pub(crate) bytes: Vec<u8>,
    order: ByteOrder,
}

impl DpxBuilder {
    /// Creates a header with `extra` bytes of user data for `width` x `height` pixels. All other fields are undefined.
    pub(crate) fn new(order: ByteOrder, width: u32, height: u32, extra: usize) -> Self {
        let mut made = Self {
            bytes: vec![0xff; 2048],
            order,
        };
        made.bytes.extend((0..extra).map(|i| i as u8));
        let magic = match order {
            ByteOrder::Big => b"SDPX",
            ByteOrder::Little => b"XPDS",
        };
        made.bytes[..4].copy_from_slice(magic);
        let offset = 2048 + extra as u32;
        for (at, value) in [
            (4, offset),
            (32, extra as u32),
            (772, width),
            (776, height),
            (780, 0),
            (808, offset),
            (812, 0),
        ] {
            made.put32(at, value);
        }
        for (at, value) in [(768, 0), (770, 1), (804, 0), (806, 0)] {
            made.put16(at, value);
        }
        made
    }

    /// Sets descriptor, bits and packing of the image element.
    pub(crate) fn element(mut self, descriptor: u8, bits: u8, packing: u16) -> Self {
        self.bytes[800] = descriptor;
        self.bytes[803] = bits;
        self.put16(804, packing);
        self
    }

    pub(crate) fn put16(&mut self, at: usize, value: u16) {
        let bytes = match self.order {
            ByteOrder::Big => value.to_be_bytes(),
            ByteOrder::Little => value.to_le_bytes(),
        };
        self.bytes[at..at + 2].copy_from_slice(&bytes);
    }

    pub(crate) fn put32(&mut self, at: usize, value: u32) {
        let bytes = match self.order {
            ByteOrder::Big => value.to_be_bytes(),
            ByteOrder::Little => value.to_le_bytes(),
        };
        self.bytes[at..at + 4].copy_from_slice(&bytes);
    }

    pub(crate) fn words16(mut self, words: &[u16]) -> Self {
        for &word in words {
            self.bytes.extend([0; 2]);
            self.put16(self.bytes.len() - 2, word);
        }
        self
    }

    pub(crate) fn words32(mut self, words: &[u32]) -> Self {
        for &word in words {
            self.bytes.extend([0; 4]);
            self.put32(self.bytes.len() - 4, word);
        }
        self
    }

    /// Writes the file with its length in the header. Returns its bytes.
    pub(crate) fn save(mut self, path: &Path) -> Vec<u8> {
        self.put32(16, self.bytes.len() as u32);
        fs::write(path, &self.bytes).expect("the test's own file");
        self.bytes
    }
}

/// Returns the integers of a channel.
fn codes(plate: &RasterImage, name: &str) -> Vec<u16> {
    let full_scale = f32::from(plate.sample_format().full_scale().expect("integers"));
    let plane = plate.plane(name).expect("a channel");
    plane
        .iter()
        .map(|v| (v * full_scale).round() as u16)
        .collect()
}

#[test]
fn every_layout_round_trips_to_the_byte() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (path, out) = (folder.path().join("a.dpx"), folder.path().join("b.dpx"));
    // Two pixels a line, two lines; R, G, B of the pixels are 1, 2, 3; 4, 5, 6 and so on.
    let ten = |a: u32, b: u32, c: u32, up: u32| (a << 20 | b << 10 | c) << up;
    for order in [ByteOrder::Big, ByteOrder::Little] {
        let made = |descriptor, bits, packing| {
            DpxBuilder::new(order, 2, 2, 40).element(descriptor, bits, packing)
        };
        let rgb10 = |up| {
            [
                ten(1, 2, 3, up),
                ten(4, 5, 6, up),
                ten(7, 8, 9, up),
                ten(1021, 1022, 1023, up),
            ]
        };
        let rgb: [&[u16]; 3] = [&[1, 4, 7, 1021], &[2, 5, 8, 1022], &[3, 6, 9, 1023]];
        let twelve = [1, 2, 3, 4, 5, 6, 7, 8, 9, 1021, 1022, 1023];
        for (file, depth, up) in [
            (made(50, 10, 1).words32(&rgb10(2)), SampleFormat::U10, 0),
            (made(50, 10, 2).words32(&rgb10(0)), SampleFormat::U10, 0),
            (
                made(50, 12, 1).words16(&twelve.map(|v| v << 4)),
                SampleFormat::U12,
                0,
            ),
            (made(50, 12, 2).words16(&twelve), SampleFormat::U12, 0),
            (
                made(50, 16, 0).words16(&twelve.map(|v| v << 5)),
                SampleFormat::U16,
                5,
            ),
            (
                made(50, 16, 1).words16(&twelve.map(|v| v << 5)),
                SampleFormat::U16,
                5,
            ),
        ] {
            let bytes = file.save(&path);
            let plate = RasterImage::open(&path).expect("opens");
            assert_eq!(
                (plate.sample_format(), plate.width(), plate.height()),
                (depth, 2, 2)
            );
            for (name, want) in ["R", "G", "B"].iter().zip(rgb) {
                let want: Vec<u16> = want.iter().map(|v| v << up).collect();
                assert_eq!(codes(&plate, name), want, "{depth} {name}");
            }
            assert!(plate.write(&out).expect("writes").is_empty());
            assert!(fs::read(&out).expect("reads") == bytes, "{depth}");
        }
        // Four components, three to a word, padded at the end of the line: R, G, B, A = 1, 2, 3, 4; 5, 6, 7, 8.
        let line = [ten(1, 2, 3, 2), ten(4, 5, 6, 2), ten(7, 8, 0, 2)];
        for (descriptor, names) in [(51, ["R", "G", "B", "A"]), (52, ["A", "B", "G", "R"])] {
            let file = made(descriptor, 10, 1).words32(&[line, line].concat());
            let bytes = file.save(&path);
            let plate = RasterImage::open(&path).expect("opens");
            for (at, name) in names.iter().enumerate() {
                let at = at as u16;
                assert_eq!(codes(&plate, name), [1 + at, 5 + at, 1 + at, 5 + at]);
            }
            plate.write(&out).expect("writes");
            assert!(fs::read(&out).expect("reads") == bytes);
        }
        // The first sample of a single component is in the low bits.
        let file = made(6, 10, 1).words32(&[ten(0, 2, 1, 2), ten(0, 4, 3, 2)]);
        let bytes = file.save(&path);
        let plate = RasterImage::open(&path).expect("opens");
        assert_eq!(codes(&plate, "Y"), [1, 2, 3, 4]);
        plate.write(&out).expect("writes");
        assert!(fs::read(&out).expect("reads") == bytes);
    }
}

#[test]
fn lines_are_found_with_any_padding() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (path, out) = (folder.path().join("a.dpx"), folder.path().join("b.dpx"));
    let line = |y: u8| [y, 1, 2, 3, 4];
    // One component of 8 bits, five a line: aligned to words, not aligned, aligned with stated padding, and with bytes
    // after the pixels where these can be distinguished.
    for (stated, padding, tail) in [(0, 3, 0), (0, 0, 0), (3, 3, 9), (7, 7, 2), (0, 3, 6)] {
        let mut made = DpxBuilder::new(ByteOrder::Big, 5, 3, 0).element(6, 8, 0);
        made.put32(812, stated);
        for y in 0..3 {
            made.bytes.extend(line(y));
            made.bytes.extend(vec![0; padding]);
        }
        made.bytes.extend(vec![0x77; tail]);
        let bytes = made.save(&path);
        let plate = RasterImage::open(&path).expect("opens");
        assert_eq!(
            codes(&plate, "Y"),
            [line(0), line(1), line(2)]
                .concat()
                .into_iter()
                .map(u16::from)
                .collect::<Vec<_>>(),
            "{stated} {padding}"
        );
        plate.write(&out).expect("writes");
        assert!(
            fs::read(&out).expect("reads") == bytes,
            "{stated} {padding}"
        );
    }
}

#[test]
fn unsupported_features_are_refused_by_field() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.dpx");
    let valid = || {
        DpxBuilder::new(ByteOrder::Big, 2, 1, 0)
            .element(50, 10, 1)
            .words32(&[0, 0])
    };
    valid().save(&path);
    RasterImage::open(&path).expect("valid");
    type Damage = (fn(&mut DpxBuilder), &'static str);
    let damages: [Damage; 13] = [
        (|m| m.put16(806, 1), "encoding: is 1, run-length encoded"),
        (|m| m.put16(806, 7), "encoding: is 7"),
        (|m| m.put16(804, 9), "packing: is 9"),
        (|m| m.put16(768, 1), "image orientation: is 1"),
        (|m| m.put16(770, 2), "number of image elements: is 2"),
        (|m| m.put16(770, 0), "number of image elements: is 0"),
        (|m| m.put32(780, 1), "data sign"),
        (|m| m.bytes[800] = 100, "descriptor: is 100"),
        (|m| m.bytes[803] = 32, "bit size: is 32"),
        (|m| m.put32(808, 1024), "offset to image data: is 1024"),
        (|m| m.put32(808, 1 << 20), "offset to image data"),
        (
            |m| m.put32(772, 3),
            "image data: take 12 bytes, but 8 are left",
        ),
        (|m| m.put32(776, 0), "pixels per line, lines: claims 2 x 0"),
    ];
    for (damage, says) in damages {
        let mut made = valid();
        damage(&mut made);
        made.save(&path);
        let error = RasterImage::open(&path).expect_err(says).to_string();
        assert!(error.contains("a.dpx") && error.contains(says), "{error}");
        assert!(error.contains("; "), "a remedy: {error}");
    }
    for (width, height) in [(u32::MAX, 1), (200_000, 200_000), (1, u32::MAX), (0, 1)] {
        let mut made = valid();
        made.put32(772, width);
        made.put32(776, height);
        made.save(&path);
        RasterImage::open(&path).expect_err("absurd");
    }
    // An element without an offset of its own begins at that of the file.
    let mut made = valid();
    made.put32(808, u32::MAX);
    made.save(&path);
    RasterImage::open(&path).expect("opens");
}

#[test]
fn colour_statements_are_removed_when_the_colour_space_changes() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (path, out) = (folder.path().join("a.dpx"), folder.path().join("b.dpx"));
    let mut made = DpxBuilder::new(ByteOrder::Big, 1, 1, 0).element(50, 16, 0);
    (made.bytes[801], made.bytes[802]) = (1, 6);
    made.bytes[820..840].copy_from_slice(b"sRGB (IEC 61966-2-1)");
    made.words16(&[1, 2, 3]).save(&path);
    let mut plate = PlateFile::open(&path, &PlateOptions::default()).expect("opens");
    plate.set_colour_space("ACEScct");
    let warnings = plate.write(&out).expect("writes").concat();
    let names = "`ACEScct`: the transfer characteristic, the colorimetric specification, the description as sRGB";
    assert!(warnings.contains(names), "{warnings}");
    let file = fs::read(&out).expect("reads");
    assert_eq!((file[801], file[802], file[820]), (0, 0, 0));
    let mut again = PlateFile::open(&out, &PlateOptions::default()).expect("opens");
    again.set_colour_space("ACEScg");
    assert_eq!(again.write(&out).expect("writes"), [""; 0]);
}

#[test]
fn contiguous_samples_are_distinguished_from_filled_words() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (path, out) = (folder.path().join("a.dpx"), folder.path().join("b.dpx"));
    for order in [ByteOrder::Big, ByteOrder::Little] {
        // A line of eight samples of 12 bits: 1 to 8 from the low bits up.
        let mut bits = 0_u128;
        for (at, code) in (1..=8_u128).enumerate() {
            bits |= code << (12 * at);
        }
        let line = [bits as u32, (bits >> 32) as u32, (bits >> 64) as u32];
        assert_eq!(line[0], 0x0300_2001);
        let made = DpxBuilder::new(order, 8, 2, 0).element(6, 12, 0);
        let bytes = made.words32(&[line, line].concat()).save(&path);
        let plate = RasterImage::open(&path).expect("opens");
        assert_eq!(plate.sample_format(), SampleFormat::U12);
        let want: Vec<u16> = (1..=8).chain(1..=8).collect();
        assert_eq!(codes(&plate, "Y"), want);
        plate.write(&out).expect("writes");
        assert!(fs::read(&out).expect("reads") == bytes);
    }
    // Sixteen pixels take fifteen words, but sixteen filled ones.
    for (words, says) in [(30, None), (32, Some("the length of filled words"))] {
        let made = DpxBuilder::new(ByteOrder::Big, 16, 2, 0).element(50, 10, 0);
        made.words32(&vec![0; words]).save(&path);
        match (RasterImage::open(&path), says) {
            (Err(error), Some(says)) => {
                let error = error.to_string();
                assert!(
                    error.contains("packing: is 0") && error.contains(says),
                    "{error}"
                );
            }
            (opened, says) => assert!(opened.is_ok() && says.is_none(), "{words}"),
        }
    }
}

#[test]
fn the_assumed_encoding_is_reported() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("a.dpx");
    let open = |transfer: u8, encoding: Option<Encoding>| {
        let mut made = DpxBuilder::new(ByteOrder::Big, 1, 1, 0).element(50, 16, 0);
        made.bytes[801] = transfer;
        made.put32(1628, 2);
        made.put32(1632, 1);
        made.words16(&[0x8000, 0, 0xffff]).save(&path);
        let options = PlateOptions {
            encoding,
            ..PlateOptions::default()
        };
        let plate = PlateFile::open(&path, &options).expect("opens");
        assert_eq!(plate.pixel_aspect(), 2.0);
        (plate.read_warnings().concat(), plate.colour()[0][0])
    };
    let half = f32::from(0x8000_u16) / 65535.0;
    let (warnings, red) = open(1, None);
    assert!(
        warnings.contains("printing density") && warnings.contains("--encoding"),
        "{warnings}"
    );
    assert_eq!(red, half);
    let (warnings, red) = open(2, None);
    assert!(
        warnings.contains("linear") && !warnings.contains("--encoding"),
        "{warnings}"
    );
    assert_eq!(red, half);
    let (warnings, red) = open(6, Some(Encoding::Srgb));
    assert!(
        warnings.contains("ITU-R 709-4") && warnings.contains("sRGB"),
        "{warnings}"
    );
    assert!(!warnings.contains("--encoding"), "{warnings}");
    assert_eq!(red, Encoding::Srgb.decode(half));
}
