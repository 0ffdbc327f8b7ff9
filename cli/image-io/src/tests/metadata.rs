//! Metadata of PNG and TIFF files: they pass through, and those that become invalid are left out with a warning.

use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

use crate::description::Description;
use crate::plate::{PlateFile, PlateOptions};
use crate::raster::RasterImage;
use crate::samples::SampleFormat;

/// Returns a chunk with its length and checksum, as the encoder writes it after the header.
pub(crate) fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let encoder = png::Encoder::new(&mut file, 1, 1);
    let mut writer = encoder.write_header().expect("a header");
    let kind = png::chunk::ChunkType(*name);
    writer.write_chunk(kind, data).expect("a chunk");
    drop(writer);
    // After the signature and IHDR.
    file[33..33 + 12 + data.len()].to_vec()
}

/// Writes an RGB PNG of 3 x 2 pixels with chunks before and after its pixels.
pub(crate) fn write_png(path: &Path, bits: png::BitDepth, before: &[Vec<u8>], after: &[Vec<u8>]) {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 3, 2);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(bits);
    let bytes = if bits == png::BitDepth::Sixteen {
        36
    } else {
        18
    };
    let pixels: Vec<u8> = (0..bytes).map(|i| i * 7).collect();
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&pixels).expect("pixels");
    writer.finish().expect("an end");
    let end = file.split_off(file.len() - 12);
    let pixels = file.split_off(33);
    for part in [before, &[pixels], after, &[end]].concat() {
        file.extend(part);
    }
    fs::write(path, file).expect("the test's own file");
}

/// Returns names and contents of all chunks in order, without the pixels.
fn chunks(path: &Path) -> Vec<(String, Vec<u8>)> {
    let file = fs::read(path).expect("readable");
    let mut all = Vec::new();
    let mut rest = &file[8..];
    while rest.len() >= 12 {
        let size = u32::from_be_bytes(rest[..4].try_into().expect("four")) as usize;
        let name = String::from_utf8_lossy(&rest[4..8]).into_owned();
        if !["IHDR", "IDAT", "IEND"].contains(&&name[..]) {
            all.push((name, rest[8..8 + size].to_vec()));
        }
        rest = &rest[12 + size..];
    }
    all
}

/// Returns chunks of colour, size and date, and two private ones, of which one may be copied.
pub(crate) fn usual_chunks() -> Vec<Vec<u8>> {
    vec![
        chunk(b"gAMA", &45_455_u32.to_be_bytes()),
        chunk(b"cHRM", &[0, 0, 0x7a, 0x26].repeat(8)),
        chunk(b"sRGB", &[1]),
        chunk(b"cICP", &[1, 13, 0, 1]),
        chunk(b"sBIT", &[7, 8, 7]),
        chunk(b"bKGD", &[0, 1, 0, 2, 0, 3]),
        chunk(b"pHYs", &[0, 0, 11, 19, 0, 0, 11, 20, 1]),
        chunk(b"tIME", &[7, 0xea, 11, 22, 10, 0, 0]),
        chunk(b"prVt", b"may be copied"),
        chunk(b"prVT", b"may not"),
    ]
}

#[test]
fn png_chunks_pass_through() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("a.png"), folder.path().join("b.png"));
    let after = [
        chunk(b"tEXt", b"Author\0me"),
        chunk(b"iTXt", "Title\0\0\0de\0Titel\0Gr\u{fc}\u{df}e".as_bytes()),
        chunk(b"eXIf", b"II*\0\x08\0\0\0\0\0\0\0\0\0"),
    ];
    for bits in [png::BitDepth::Eight, png::BitDepth::Sixteen] {
        write_png(&path, bits, &usual_chunks(), &after);
        let plate = RasterImage::open(&path).expect("opens");
        assert_eq!(plate.write(&out).expect("writes"), [""; 0]);
        let (mut was, mut is) = (chunks(&path), chunks(&out));
        assert_eq!(was.len(), 13);
        was.sort();
        is.sort();
        assert_eq!(is, was);
        assert_eq!(
            image::open(&out).expect("reads"),
            image::open(&path).expect("reads")
        );
    }
    // A profile keeps its name, and a chunk with a wrong checksum is dropped.
    let mut profile = b"My profile\0\0".to_vec();
    let mut packed = deflate(b"no profile at all");
    profile.append(&mut packed);
    let mut bad = chunk(b"pHYs", &[0; 9]);
    bad[10] ^= 1;
    write_png(
        &path,
        png::BitDepth::Eight,
        &[chunk(b"iCCP", &profile), bad],
        &[],
    );
    let plate = RasterImage::open(&path).expect("opens");
    assert_eq!(
        plate.metadata.icc_profile(),
        Some(&b"no profile at all"[..])
    );
    plate.write(&out).expect("writes");
    assert_eq!(chunks(&out), [("iCCP".to_owned(), profile)]);
}

/// Compresses bytes as in a PNG chunk.
fn deflate(data: &[u8]) -> Vec<u8> {
    use tiff::encoder::compression::{CompressionAlgorithm, Deflate, DeflateLevel};
    let mut packed = Vec::new();
    Deflate::with_level(DeflateLevel::Fast)
        .write_to(&mut packed, data)
        .expect("packs");
    packed
}

#[test]
fn invalid_png_chunks_are_left_out_with_a_warning() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("a.png"), folder.path().join("b.png"));
    let names = |path: &Path| -> Vec<String> { chunks(path).into_iter().map(|c| c.0).collect() };
    write_png(&path, png::BitDepth::Sixteen, &usual_chunks(), &[]);
    let mut plate = RasterImage::open(&path).expect("opens");
    plate.replace("R", vec![0.5; 6]).expect("six");
    let warnings = plate.write(&out).expect("writes").concat();
    assert!(warnings.ends_with(": sBIT, tIME, prVT"), "{warnings}");
    let kept = ["gAMA", "cHRM", "sRGB", "cICP", "bKGD", "pHYs", "prVt"];
    assert_eq!(names(&out), kept);
    // In another colour space.
    let mut plate = PlateFile::open(&path, &PlateOptions::default()).expect("opens");
    plate.set_colour_space("ACEScct");
    let warnings = plate.write(&out).expect("writes").concat();
    assert!(
        warnings.contains("`ACEScct`: gAMA, cHRM, sRGB, cICP"),
        "{warnings}"
    );
    assert_eq!(
        names(&out),
        ["sBIT", "bKGD", "pHYs", "tIME", "prVt", "prVT"]
    );
    // In another format.
    let plate = PlateFile::open(&path, &PlateOptions::default()).expect("opens");
    let tiff = folder.path().join("a.tif");
    let warnings = plate.write(&tiff).expect("writes").concat();
    assert!(
        warnings.contains("gAMA, cHRM") && warnings.contains("of the PNG are left out"),
        "{warnings}"
    );
    // Of an animation the first frame is kept.
    let animation = [
        chunk(b"acTL", &[0, 0, 0, 1, 0, 0, 0, 0]),
        chunk(
            b"fcTL",
            &[
                0, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 0,
            ],
        ),
    ];
    write_png(&path, png::BitDepth::Eight, &animation, &[]);
    let plate = RasterImage::open(&path).expect("opens");
    let warnings = plate.write(&out).expect("writes").concat();
    assert!(warnings.contains("only the first frame"), "{warnings}");
    assert!(chunks(&out).is_empty());
}

/// Writes a 16-bit TIFF of 3 x 2 pixels with tags of many types and an EXIF directory.
pub(crate) fn write_tiff(path: &Path) {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file).expect("a file");
    let mut exif = encoder.extra_directory().expect("a directory");
    exif.write_tag(Tag::Unknown(0xa434), "A lens")
        .expect("a tag");
    exif.write_tag(Tag::Unknown(37_500), &[1_u8, 2, 3][..])
        .expect("a tag");
    let exif = exif.finish_with_offsets().expect("written");
    let mut image = encoder
        .new_image::<colortype::RGB16>(3, 2)
        .expect("an image");
    let tags = image.encoder();
    for (tag, text) in [
        (Tag::ImageDescription, "a description"),
        (Tag::Artist, "an artist"),
        (Tag::Copyright, "nobody"),
        (Tag::DateTime, "2026:11:22 10:00:00"),
        (Tag::Software, "a test"),
        (Tag::Unknown(269), "a document"),
        (Tag::Unknown(285), "a page"),
        (Tag::Unknown(65_000), "a private text"),
    ] {
        tags.write_tag(tag, text).expect("a tag");
    }
    tags.write_tag(Tag::Unknown(65_001), &[1.5_f64, -2.5][..])
        .expect("a tag");
    tags.write_tag(Tag::Unknown(65_002), -7_i32).expect("a tag");
    tags.write_tag(Tag::Unknown(297), &[3_u16, 9][..])
        .expect("a tag");
    tags.write_tag(Tag::Unknown(37_724), &[0_u8; 8][..])
        .expect("a tag");
    tags.write_tag(Tag::Unknown(318), &[0.3127_f32, 0.329][..])
        .expect("a tag");
    tags.write_tag(Tag::ExifDirectory, exif.offset)
        .expect("a tag");
    image.resolution(
        tiff::tags::ResolutionUnit::Inch,
        tiff::encoder::Rational { n: 601, d: 2 },
    );
    let pixels: Vec<u16> = (0..18).map(|i| i * 3001).collect();
    image.write_data(&pixels).expect("pixels");
    fs::write(path, file.into_inner()).expect("the test's own file");
}

/// Returns all tags of a file and its EXIF directory as text, except those about the storage of the pixels.
fn tags(path: &Path) -> Vec<String> {
    let file = fs::File::open(path).expect("opens");
    let mut decoder = tiff::decoder::Decoder::new(file).expect("a TIFF");
    let mut all = Vec::new();
    for entry in decoder.tag_iter() {
        let (tag, value) = entry.expect("a value");
        let stored = [259, 273, 278, 279, 284, 317, 0x8769, 37_724];
        if !stored.contains(&tag.to_u16()) {
            all.push(format!("{tag:?} {value:?}"));
        }
    }
    let exif = decoder.find_tag_unsigned::<u64>(Tag::ExifDirectory);
    if let Some(at) = exif.expect("reads") {
        let at = tiff::tags::IfdPointer(at);
        let directory = decoder.read_directory(at).expect("a directory");
        let own = decoder.read_directory_tags(&directory);
        all.extend(own.tag_iter().map(|entry| format!("exif {entry:?}")));
    }
    all
}

#[test]
fn tiff_tags_pass_through() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("a.tif"), folder.path().join("b.tif"));
    write_tiff(&path);
    let plate = RasterImage::open(&path).expect("opens");
    let warnings = plate.write(&out).expect("writes").concat();
    assert!(
        warnings.ends_with(": Photoshop's layers, the maker's note"),
        "{warnings}"
    );
    let mut was = tags(&path);
    assert!(was.iter().any(|tag| tag.contains("a private text")));
    was.retain(|tag| !tag.contains("37500"));
    assert_eq!(tags(&out), was);
    assert!(was.iter().any(|tag| tag.contains("A lens")), "{was:?}");
    let lines = Description::read(&path).expect("opens").lines();
    for line in [
        "Artist: an artist",
        "tag 65000: a private text",
        "LensModel: A lens",
    ] {
        assert!(lines.iter().any(|own| own.contains(line)), "{lines:?}");
    }
    // The written file loses nothing more.
    let again = folder.path().join("c.tif");
    let plate = RasterImage::open(&out).expect("opens");
    assert_eq!(plate.write(&again).expect("writes"), [""; 0]);
    assert!(fs::read(&again).expect("reads") == fs::read(&out).expect("reads"));
    // In another colour space the white point is removed.
    let mut plate = PlateFile::open(&path, &PlateOptions::default()).expect("opens");
    plate.set_colour_space("ACEScct");
    let warnings = plate.write(&out).expect("writes").concat();
    assert!(warnings.contains("`ACEScct`: WhitePoint"), "{warnings}");
    assert!(!tags(&out).iter().any(|tag| tag.contains("318")));
}

/// Writes a TIFF of half floats, which the `tiff` crate does not.
fn write_half_tiff(path: &Path, samples: &[u16]) {
    let mut file = b"II*\0\x08\0\0\0".to_vec();
    let entries: [(u16, u16, u32, u32); 9] = [
        (256, 4, 1, samples.len() as u32),
        (257, 4, 1, 1),
        (258, 3, 1, 16),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (273, 4, 1, 8 + 2 + 9 * 12 + 4),
        (277, 3, 1, 1),
        (279, 4, 1, samples.len() as u32 * 2),
        (339, 3, 1, 3),
    ];
    file.extend(9_u16.to_le_bytes());
    for (tag, kind, count, value) in entries {
        file.extend(tag.to_le_bytes());
        file.extend(kind.to_le_bytes());
        file.extend(count.to_le_bytes());
        file.extend(value.to_le_bytes());
    }
    file.extend([0; 4]);
    file.extend(samples.iter().flat_map(|s| s.to_le_bytes()));
    fs::File::create(path)
        .and_then(|mut out| out.write_all(&file))
        .expect("the test's own file");
}

#[test]
fn half_float_tiff_round_trips() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("a.tif"), folder.path().join("b.tif"));
    // 1, -1.5, the largest, the smallest, infinity, -0.
    let bits = [0x3c00, 0xbe00, 0x7bff, 0x0001, 0x7c00, 0x8000];
    write_half_tiff(&path, &bits);
    let plate = RasterImage::open(&path).expect("opens");
    assert_eq!(plate.sample_format(), SampleFormat::F16);
    assert_eq!(plate.write(&out).expect("writes"), [""; 0]);
    let back = RasterImage::open(&out).expect("opens");
    assert_eq!(back.sample_format(), SampleFormat::F16);
    let as_bits = |plate: &RasterImage| -> Vec<u16> {
        let samples = plate.plane("Y").expect("Y").iter();
        samples.map(|s| half::f16::from_f32(*s).to_bits()).collect()
    };
    assert_eq!(as_bits(&back), bits);
    // Samples that are too large are clipped with a warning, as quantisation does.
    let mut plate = plate;
    plate
        .replace("Y", vec![1e6, -1e6, 0.1, -3.0, f32::INFINITY, 0.0])
        .expect("six");
    let warnings = plate.write(&out).expect("writes");
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("1 samples over 65504"), "{warnings:?}");
    let back = RasterImage::open(&out).expect("opens");
    plate.quantise();
    assert_eq!(back.plane("Y"), plate.plane("Y"));
    assert_eq!(back.plane("Y").expect("Y")[..2], [65_504.0, -65_504.0]);
}
