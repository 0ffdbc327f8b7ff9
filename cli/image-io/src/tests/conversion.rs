//! Plates converted to another format: samples, and warnings about what is lost.

use std::fs;
use std::path::{Path, PathBuf};

use exr::image::FlatSamples;
use exr::prelude::Compression;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageBuffer, ImageEncoder, Luma, Rgb, Rgba};

use super::dpx_files::DpxBuilder;
use super::{image, part, patch, save};
use crate::format::{AlphaSupport, Format};
use crate::formats::dpx::byte_order::ByteOrder;
use crate::formats::exr::ExrImage;
use crate::plate::{PlateFile, PlateOptions};
use crate::raster::RasterImage;
use crate::rgbe;
use crate::samples::{Encoding, SampleFormat};
use seidel_optics::Rectangle;

fn open(path: &Path) -> PlateFile {
    PlateFile::open(path, &PlateOptions::default()).expect("opens")
}

/// Writes the plate `from` as `to`. Returns the warnings.
fn convert(from: &Path, to: &Path) -> String {
    open(from).write(to).expect("writes").join("\n")
}

fn samples(plate: &ExrImage, name: &str) -> Vec<f32> {
    let channels = plate.channels();
    let own = channels.iter().find(|c| c.name == name);
    plate.samples(own.expect("a channel").id)
}

/// Writes an 8-bit PNG with alpha.
fn rgba8(folder: &Path) -> PathBuf {
    let path = folder.join("in.png");
    let pixel = |x: u32, y: u32| {
        Rgba([
            (x * 60) as u8,
            (y * 80) as u8,
            255,
            ((x + 4 * y) * 15) as u8,
        ])
    };
    ImageBuffer::from_fn(4, 3, pixel)
        .save(&path)
        .expect("the test's own file");
    path
}

#[test]
fn eight_bits_round_trip_through_scene_linear_exr() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (png, exr) = (rgba8(folder.path()), folder.path().join("a.exr"));
    let warnings = convert(&png, &exr);
    assert!(
        warnings.contains("8-bit samples are written as half float"),
        "{warnings}"
    );
    let plate = ExrImage::open(&exr).expect("opens");
    let flat = RasterImage::open(&png).expect("opens");
    let alpha = flat.plane("A").expect("alpha");
    for name in ["R", "G", "B"] {
        let codes = flat.plane(name).expect("colour");
        let want = codes
            .iter()
            .zip(alpha)
            .map(|(&c, a)| Encoding::Srgb.decode(c) * a);
        for (got, want) in samples(&plate, name).into_iter().zip(want) {
            assert!((got - want).abs() <= want.abs() / 2048.0, "{got} {want}");
        }
    }
    // Back again: where alpha is not zero, no code differs by half a step.
    let back = folder.path().join("b.png");
    let warnings = convert(&exr, &back);
    assert!(
        warnings.contains("half float samples are written as 16-bit, sRGB-encoded"),
        "{warnings}"
    );
    let back = RasterImage::open(&back).expect("opens");
    assert_eq!(back.sample_format(), SampleFormat::U16);
    for name in ["R", "G", "B"] {
        let pairs = flat.plane(name).expect("colour").iter();
        for ((was, is), alpha) in pairs.zip(back.plane(name).expect("colour")).zip(alpha) {
            let want = if *alpha > 0.0 { *was } else { 0.0 };
            assert!((is - want).abs() < 0.5 / 255.0, "{is} {want}");
        }
    }
}

#[test]
fn integer_codes_are_kept_between_integer_formats() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let png = rgba8(folder.path());
    let flat = RasterImage::open(&png).expect("opens");
    let tif = folder.path().join("a.tif");
    assert_eq!(convert(&png, &tif), "");
    let tiff = RasterImage::open(&tif).expect("opens");
    assert_eq!(
        (tiff.sample_format(), tiff.names()),
        (SampleFormat::U8, flat.names())
    );
    assert!(!open(&tif).is_premultiplied());
    for name in flat.names() {
        assert_eq!(tiff.plane(name), flat.plane(name));
    }
    // 16 bits of grey to DPX and back, to the code.
    let (grey, dpx, back) = (
        folder.path().join("y.png"),
        folder.path().join("y.dpx"),
        folder.path().join("y.tif"),
    );
    ImageBuffer::from_fn(7, 5, |x, y| Luma([(x * 9001 + y * 257) as u16]))
        .save(&grey)
        .expect("the test's own file");
    assert_eq!(convert(&grey, &dpx), "");
    let warnings = convert(&dpx, &back);
    assert!(warnings.contains("header of the DPX"), "{warnings}");
    let (grey, back) = (RasterImage::open(&grey), RasterImage::open(&back));
    assert_eq!(
        grey.expect("opens").plane("Y"),
        back.expect("opens").plane("Y")
    );
    // 8 bits with alpha to DPX: 16 bits, premultiplied, described as sRGB.
    let dpx = folder.path().join("a.dpx");
    let warnings = convert(&png, &dpx);
    assert!(
        warnings.contains("written as 16-bit, sRGB-encoded"),
        "{warnings}"
    );
    let plate = open(&dpx);
    assert!(plate.is_premultiplied());
    let warnings = plate.read_warnings().concat();
    assert!(
        warnings.contains("read as sRGB") && !warnings.contains("--encoding"),
        "{warnings}"
    );
    let source = open(&png);
    let alpha = source.alpha().expect("alpha");
    for (got, was) in plate.colour().iter().zip(source.colour()) {
        for ((got, was), alpha) in got.iter().zip(was).zip(&alpha) {
            let step = Encoding::Srgb.encode(*got) - Encoding::Srgb.encode(was * alpha);
            assert!(step.abs() <= 0.51 / 65535.0, "{got} {was} {alpha}");
        }
    }
}

/// Writes an EXR of two parts whose data window is 6 x 4 at (-2, 1) and whose display window is 20 x 10.
fn windowed(folder: &Path) -> PathBuf {
    let path = folder.join("in.exr");
    let ramp = |scale: f32| FlatSamples::F32((0..24).map(|i| (i as f32 - 4.0) * scale).collect());
    let parts = vec![
        part(
            Some("rgba"),
            (6, 4),
            (-2, 1),
            Compression::ZIP16,
            vec![
                ("A", FlatSamples::F32(vec![0.5; 24])),
                ("B", ramp(0.3)),
                ("G", ramp(0.2)),
                ("R", ramp(0.1)),
                ("spec.R", ramp(1.0)),
            ],
        ),
        part(
            Some("depth"),
            (6, 4),
            (-2, 1),
            Compression::ZIP16,
            vec![("Z", ramp(1.0))],
        ),
    ];
    save(&image(parts), &path);
    path
}

#[test]
fn everything_that_a_format_cannot_store_causes_a_warning() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let exr = windowed(folder.path());
    let source = open(&exr);
    let at = |plane: &[f32], x: usize, y: usize| plane[y * 20 + x];
    for format in Format::writable().filter(|format| !format.capabilities.layers) {
        let out = folder.path().join("a").with_extension(format.extension());
        let warnings = convert(&exr, &out);
        for part in [
            "rgba:spec.R, depth:Z are left out",
            "cropped to its display window",
            "padded with black",
        ] {
            assert!(
                warnings.contains(part),
                "{format}: `{part}` is missing in {warnings}"
            );
        }
        let stored = (format.sample_format)(SampleFormat::F32, 4);
        let alpha = format.capabilities.alpha;
        let clipped = warnings.contains("2 samples below 0") && warnings.contains("are clipped");
        assert_eq!(clipped, stored != SampleFormat::F32, "{warnings}");
        assert_eq!(
            warnings.contains("over 1 "),
            stored.is_integer(),
            "{warnings}"
        );
        assert_eq!(
            warnings.contains("holds no alpha"),
            alpha == AlphaSupport::None,
            "{warnings}"
        );
        let plate = open(&out);
        let full = Rectangle {
            x: 0,
            y: 0,
            width: 20,
            height: 10,
        };
        assert_eq!(plate.data_window(), full);
        let red = &plate.colour()[0];
        assert_eq!(
            (at(red, 0, 0), at(red, 4, 1), at(red, 19, 9)),
            (0.0, 0.0, 0.0)
        );
        // The third column of the data window, its second line.
        let premultiplied = source.colour()[0][8];
        let want = if alpha == AlphaSupport::Unpremultiplied {
            2.0 * premultiplied
        } else {
            premultiplied
        };
        let tolerance = match stored {
            SampleFormat::F32 => 0.0,
            SampleFormat::U16 => 3e-5,
            // Blue is three times as bright.
            SampleFormat::Rgbe => 3.0 * want / 255.0,
            _ => 5e-3,
        };
        let got = at(red, 0, 2);
        assert!(
            (got - want).abs() <= tolerance,
            "{format}: {got} for {want}"
        );
        assert_eq!(plate.has_alpha(), alpha != AlphaSupport::None);
        if alpha == AlphaSupport::Either {
            assert!(plate.is_premultiplied());
        }
        if stored == SampleFormat::F32 {
            assert_eq!(at(red, 0, 1), source.colour()[0][2], "negative");
            assert!(at(red, 0, 1) < 0.0);
        }
    }
    // Colour without alpha cannot be divided by it.
    let glow = folder.path().join("glow.exr");
    let planes = ["A", "B", "G", "R"].map(|n| {
        let level = if n == "A" { 0.0 } else { 0.5 };
        (n, FlatSamples::F32(vec![level; 200]))
    });
    save(
        &image(vec![part(
            None,
            (20, 10),
            (0, 0),
            Compression::ZIP16,
            planes.to_vec(),
        )]),
        &glow,
    );
    let warnings = convert(&glow, &folder.path().join("glow.png"));
    assert!(
        warnings.contains("200 pixels of colour without alpha are black"),
        "{warnings}"
    );
    // Unpremultiplied by the user's choice.
    let options = PlateOptions {
        premultiplied: Some(false),
        ..PlateOptions::default()
    };
    let plate = PlateFile::open(&glow, &options).expect("opens");
    let warnings = plate
        .write(&folder.path().join("glow.png"))
        .expect("writes")
        .concat();
    assert!(!warnings.contains("without alpha"), "{warnings}");
    let level = open(&folder.path().join("glow.png")).colour()[0][0];
    assert!((level - 0.5).abs() < 1e-4, "{level}");
}

#[test]
fn sixteen_bits_become_float_and_colour_managed_codes_are_kept() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    ImageBuffer::from_fn(300, 2, |x, y| Rgb([(x * 218 + y) as u16, 7, 65535]))
        .save(&png)
        .expect("the test's own file");
    let warnings = convert(&png, &exr);
    assert!(
        warnings.contains("16-bit samples are written as float"),
        "{warnings}"
    );
    let back = folder.path().join("b.png");
    convert(&exr, &back);
    assert!(image::open(&back).expect("reads") == image::open(&png).expect("reads"));
    let options = PlateOptions {
        encoding: Some(Encoding::Linear),
        colour_managed: true,
        ..PlateOptions::default()
    };
    let plate = PlateFile::open(&exr, &options).expect("opens");
    let dpx = folder.path().join("a.dpx");
    let warnings = plate.write(&dpx).expect("writes").concat();
    assert!(
        warnings.contains("float samples are written as 10-bit") && !warnings.contains("sRGB"),
        "{warnings}"
    );
    let codes = RasterImage::open(&dpx).expect("opens");
    let light = plate.colour();
    let pairs = codes.plane("R").expect("R").iter().zip(&light[0]);
    for (code, light) in pairs.map(|(c, l)| (*c, *l)) {
        assert!((code - light).abs() <= 0.5001 / 1023.0, "{code} {light}");
    }
    // Its header does not state linear samples.
    assert_eq!(fs::read(&dpx).expect("reads")[801], 0);
}

/// Writes a smooth JPEG with an ICC profile.
fn jpeg(path: &Path, icc: Option<&[u8]>) {
    let pixels: Vec<u8> = (0..16 * 8 * 3)
        .map(|i| (i / 3 % 16 * 12 + 20) as u8)
        .collect();
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 95);
    if let Some(icc) = icc {
        encoder
            .set_icc_profile(icc.to_vec())
            .expect("takes a profile");
    }
    encoder
        .write_image(&pixels, 16, 8, ExtendedColorType::Rgb8)
        .expect("encodes");
    fs::write(path, bytes).expect("the test's own file");
}

#[test]
fn jpeg_is_read_only() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (path, png) = (folder.path().join("a.jpg"), folder.path().join("a.png"));
    let profile: Vec<u8> = (0..200).collect();
    jpeg(&path, Some(&profile));
    let plate = RasterImage::open(&path).expect("opens");
    assert_eq!(
        (plate.width(), plate.height(), plate.sample_format()),
        (16, 8, SampleFormat::U8)
    );
    let green = plate.plane("G").expect("G");
    assert!(
        (green[10] * 255.0 - 140.0).abs() < 6.0,
        "{}",
        green[10] * 255.0
    );
    for name in ["b.jpg", "b.jpeg", "b.gif", "b"] {
        let error = open(&path)
            .write(&folder.path().join(name))
            .expect_err(name);
        assert!(error.to_string().contains(".png"), "{error}");
    }
    assert!(plate.write(&path).is_err());
    assert_eq!(convert(&path, &png), "");
    let back = RasterImage::open(&png).expect("opens");
    assert_eq!(back.plane("G"), Some(green));
    assert_eq!(back.metadata.icc_profile(), Some(&profile[..]));
    let warnings = convert(&path, &folder.path().join("a.exr"));
    assert!(warnings.contains("ICC profile is left out"), "{warnings}");
    // Four components are CMYK. The decoder would fill a truncated image with grey.
    let sound = fs::read(&path).expect("reads");
    let frame = [0xff, 0xc0, 0, 17, 8, 0, 8, 0, 16];
    patch(
        &path,
        &[&frame[..], &[3]].concat(),
        &[&frame[..], &[4]].concat(),
    );
    let error = RasterImage::open(&path).expect_err("CMYK").to_string();
    assert!(error.contains("CMYK") && error.contains("a.jpg"), "{error}");
    for length in 0..sound.len() - 1 {
        fs::write(&path, &sound[..length]).expect("writes");
        assert!(RasterImage::open(&path).is_err(), "{length}");
    }
}

#[test]
fn hdr_keeps_its_header_lines_and_quantises() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let (path, out) = (folder.path().join("a.hdr"), folder.path().join("b.hdr"));
    // Four bytes a pixel, not run-length coded: 0.5, 0.25, 0.125 and 255 x 2^20 / 256.
    let mut bytes =
        b"#?RGBE\n# from a test\nEXPOSURE=2\nVIEW= -vtv\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
            .to_vec();
    bytes.extend([128, 64, 32, 128, 255, 0, 1, 148]);
    fs::write(&path, bytes).expect("the test's own file");
    let plate = RasterImage::open(&path).expect("opens");
    assert_eq!(plate.plane("R"), Some(&[0.5, 1_044_480.0][..]));
    assert_eq!(plate.plane("G"), Some(&[0.25, 0.0][..]));
    assert_eq!(plate.plane("B"), Some(&[0.125, 4096.0][..]));
    let warnings = open(&path).read_warnings().concat();
    assert!(warnings.contains("multiplied by 2"), "{warnings}");
    assert!(plate.write(&out).expect("writes").is_empty());
    let text = fs::read(&out).expect("reads");
    let text = String::from_utf8_lossy(&text).into_owned();
    let head =
        "#?RADIANCE\n# from a test\nEXPOSURE=2\nVIEW= -vtv\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n";
    assert!(text.starts_with(head), "{text}");
    let back = RasterImage::open(&out).expect("opens");
    for name in ["R", "G", "B"] {
        assert_eq!(back.plane(name), plate.plane(name));
    }
    // Quantisation gives the samples of the written file.
    let wild = [
        1.0e-30,
        0.999_999,
        1.0,
        0.123_456,
        3.0e38,
        65_504.0,
        0.0,
        f32::NAN,
        -3.0,
        255.9,
    ];
    for (i, &first) in wild.iter().enumerate() {
        let pixel = [
            first,
            wild[(i + 3) % wild.len()],
            wild[(i + 7) % wild.len()],
        ];
        let mut plate = plate.clone();
        for (name, value) in ["R", "G", "B"].iter().zip(pixel) {
            plate.replace(name, vec![value; 2]).expect("two");
        }
        let warnings = plate.write(&out).expect("writes");
        let poor = pixel
            .iter()
            .filter(|v| !(0.0..=rgbe::MAX_SAMPLE).contains(*v))
            .count();
        assert_eq!(warnings.len(), poor, "{pixel:?} {warnings:?}");
        plate.quantise();
        let back = RasterImage::open(&out).expect("opens");
        let brightest = pixel
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .fold(0.0, f32::max);
        for (name, value) in ["R", "G", "B"].iter().zip(pixel) {
            let held = back.plane(name).expect("there")[0];
            assert_eq!(Some(held), plate.plane(name).map(|p| p[0]), "{pixel:?}");
            if value >= 0.0 && brightest <= rgbe::MAX_SAMPLE {
                assert!(
                    (held - value).abs() <= brightest / 255.0,
                    "{held} for {value} in {pixel:?}"
                );
            }
        }
    }
    let error = {
        fs::write(
            &path,
            b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nabcd",
        )
        .expect("writes");
        RasterImage::open(&path).expect_err("XYZ").to_string()
    };
    assert!(
        error.contains("not supported") && error.contains("xyze"),
        "{error}"
    );
}

#[test]
fn provenance_is_kept_in_every_format() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = |name: &str| folder.path().join(name);
    let text = |name: &str, text: &str| (name.to_owned(), text.to_owned());
    let texts = vec![
        text("seidelCommand", "seidel apply 'a\\nb' -o c"),
        text("seidelSettings", "amount: 1\npsf: pupil"),
    ];
    let mut flat = RasterImage::open(&rgba8(folder.path())).expect("opens");
    flat.texts = texts.clone();
    flat.write(&path("0.png")).expect("writes");
    // From each format to the next, and each also to itself.
    let names = [
        "0.png", "1.dpx", "2.hdr", "3.exr", "4.tif", "5.dpx", "6.png",
    ];
    for pair in names.windows(2) {
        let (from, to) = (path(pair[0]), path(pair[1]));
        let warnings = convert(&from, &to);
        assert!(
            !warnings.contains("attributes") && !warnings.contains("lines"),
            "{warnings}"
        );
        let again = path("again").with_extension(to.extension().expect("one"));
        open(&to).write(&again).expect("writes");
        // TIFF writes its tags in another order.
        let same = fs::read(&again).expect("reads") == fs::read(&to).expect("reads");
        assert!(same || pair[1] == "4.tif", "{pair:?}");
        assert!(open(&again).colour() == open(&to).colour(), "{pair:?}");
        if to.extension().is_some_and(|e| e != "exr") {
            let mut got = RasterImage::open(&again).expect("opens").texts;
            got.sort();
            assert_eq!(got, texts, "{pair:?}");
        }
    }
    // User data of another program are kept, with a warning.
    let dpx = path("own.dpx");
    let made = DpxBuilder::new(ByteOrder::Little, 1, 1, 300).element(50, 16, 0);
    let before = made.words16(&[1, 2, 3]).save(&dpx);
    let mut flat = RasterImage::open(&dpx).expect("opens");
    assert!(flat.texts.is_empty() && flat.write(&path("x.dpx")).expect("writes").is_empty());
    flat.texts = texts;
    let warnings = flat.write(&path("x.dpx")).expect("writes").concat();
    assert!(
        warnings.contains("user data of another program"),
        "{warnings}"
    );
    assert!(fs::read(path("x.dpx")).expect("reads") == before);
}
