//! What PNG and TIFF files hold beside their pixels: it comes back, and what no longer holds is left out and told.

use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use tiff::encoder::{TiffEncoder, colortype};
use tiff::tags::Tag;

use crate::description::Description;
use crate::flat_plate::{Encoding, FlatPlate, SampleDepth};
use crate::plate::{Plate, PlateOptions};

/// A chunk with its length and checksum, by the crate that writes PNG.
fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    png_chunk(&mut bytes, *name, data);
    bytes
}

/// Lets the encoder write one chunk and takes it from behind the header.
fn png_chunk(out: &mut Vec<u8>, name: [u8; 4], data: &[u8]) {
    let mut file = Vec::new();
    let encoder = png::Encoder::new(&mut file, 1, 1);
    let mut writer = encoder.write_header().expect("a header");
    let kind = png::chunk::ChunkType(name);
    writer.write_chunk(kind, data).expect("a chunk");
    drop(writer);
    // The signature and IHDR.
    out.extend(&file[33..33 + 12 + data.len()]);
}

/// Writes an RGB PNG of 3 x 2 pixels with chunks before and behind its pixels.
pub(crate) fn write_png(path: &Path, bits: png::BitDepth, before: &[Vec<u8>], behind: &[Vec<u8>]) {
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
    for part in [before, &[pixels], behind, &[end]].concat() {
        file.extend(part);
    }
    fs::write(path, file).expect("the test's own file");
}

/// Names and contents of all chunks, in their order, pixels apart.
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

/// Chunks that say colour, size and date, one of them of nobody that is known, and a private one that may be copied.
pub(crate) fn usual() -> Vec<Vec<u8>> {
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
fn chunks_of_png_come_back_as_they_were() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("a.png"), folder.path().join("b.png"));
    let behind = [
        chunk(b"tEXt", b"Author\0me"),
        chunk(b"iTXt", "Title\0\0\0de\0Titel\0Gr\u{fc}\u{df}e".as_bytes()),
        chunk(b"eXIf", b"II*\0\x08\0\0\0\0\0\0\0\0\0"),
    ];
    for bits in [png::BitDepth::Eight, png::BitDepth::Sixteen] {
        write_png(&path, bits, &usual(), &behind);
        let plate = FlatPlate::open(&path).expect("opens");
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
    // A profile keeps its name, and a checksum that is wrong is not made right.
    let mut profile = b"My profile\0\0".to_vec();
    let mut packed = flate(b"no profile at all");
    profile.append(&mut packed);
    let mut bad = chunk(b"pHYs", &[0; 9]);
    bad[10] ^= 1;
    write_png(
        &path,
        png::BitDepth::Eight,
        &[chunk(b"iCCP", &profile), bad],
        &[],
    );
    let plate = FlatPlate::open(&path).expect("opens");
    assert_eq!(plate.icc().as_deref(), Some(&b"no profile at all"[..]));
    plate.write(&out).expect("writes");
    assert_eq!(chunks(&out), [("iCCP".to_owned(), profile)]);
}

/// Packed as PNG packs.
fn flate(data: &[u8]) -> Vec<u8> {
    use tiff::encoder::compression::{CompressionAlgorithm, Deflate, DeflateLevel};
    let mut packed = Vec::new();
    Deflate::with_level(DeflateLevel::Fast)
        .write_to(&mut packed, data)
        .expect("packs");
    packed
}

#[test]
fn chunks_that_no_longer_hold_are_left_out_and_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("a.png"), folder.path().join("b.png"));
    let names = |path: &Path| -> Vec<String> { chunks(path).into_iter().map(|c| c.0).collect() };
    write_png(&path, png::BitDepth::Sixteen, &usual(), &[]);
    let mut plate = FlatPlate::open(&path).expect("opens");
    plate.replace("R", vec![0.5; 6]).expect("six");
    let said = plate.write(&out).expect("writes").concat();
    assert!(said.ends_with(": sBIT, tIME, prVT"), "{said}");
    let kept = ["gAMA", "cHRM", "sRGB", "cICP", "bKGD", "pHYs", "prVt"];
    assert_eq!(names(&out), kept);
    // Colour in another space.
    let mut plate = Plate::open(&path, &PlateOptions::default()).expect("opens");
    plate.set_colour_space("ACEScct");
    let said = plate.write(&out).expect("writes").concat();
    assert!(said.contains("`ACEScct`: gAMA, cHRM, sRGB, cICP"), "{said}");
    assert_eq!(
        names(&out),
        ["sBIT", "bKGD", "pHYs", "tIME", "prVt", "prVT"]
    );
    // And another format.
    let plate = Plate::open(&path, &PlateOptions::default()).expect("opens");
    let tiff = folder.path().join("a.tif");
    let said = plate.write(&tiff).expect("writes").concat();
    assert!(
        said.contains("gAMA, cHRM") && said.contains("of the PNG are left out"),
        "{said}"
    );
    // An animation is one picture from here on.
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
    let plate = FlatPlate::open(&path).expect("opens");
    let said = plate.write(&out).expect("writes").concat();
    assert!(said.contains("only the first picture"), "{said}");
    assert!(chunks(&out).is_empty());
}

#[test]
fn codes_that_a_png_calls_light_are_told_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.png");
    let linear = chunk(b"gAMA", &100_000_u32.to_be_bytes());
    let said = |before: &[Vec<u8>], encoding: Option<Encoding>| {
        write_png(&path, png::BitDepth::Sixteen, before, &[]);
        let options = PlateOptions {
            encoding,
            ..PlateOptions::default()
        };
        let plate = Plate::open(&path, &options).expect("opens");
        plate.remarks().concat()
    };
    for (before, named) in [
        (vec![linear.clone()], "(gAMA)"),
        (vec![chunk(b"cICP", &[1, 8, 0, 1])], "(cICP)"),
    ] {
        let told = said(&before, None);
        assert!(
            told.contains(named) && told.contains("--encoding"),
            "{told}"
        );
        assert_eq!(said(&before, Some(Encoding::Srgb)), "");
        let lines = Description::of(&path).expect("opens").lines().concat();
        assert!(lines.contains(&named[1..5]), "{lines}");
    }
    for before in [
        vec![],
        vec![chunk(b"gAMA", &45_455_u32.to_be_bytes())],
        vec![chunk(b"sRGB", &[0]), linear.clone()],
        vec![chunk(b"cICP", &[1, 13, 0, 1]), linear],
    ] {
        assert_eq!(said(&before, None), "");
    }
}

/// A TIFF of 3 x 2 pixels with tags of many kinds and a directory of EXIF, of 16 bits.
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

/// All tags of a file, its directories of EXIF too, as text, but for those that say where pixels lie.
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
fn tags_of_tiff_come_back_as_they_were() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("a.tif"), folder.path().join("b.tif"));
    write_tiff(&path);
    let plate = FlatPlate::open(&path).expect("opens");
    let said = plate.write(&out).expect("writes").concat();
    assert!(
        said.ends_with(": Photoshop's layers, the maker's note"),
        "{said}"
    );
    let mut was = tags(&path);
    assert!(was.iter().any(|tag| tag.contains("a private text")));
    was.retain(|tag| !tag.contains("37500"));
    assert_eq!(tags(&out), was);
    assert!(was.iter().any(|tag| tag.contains("A lens")), "{was:?}");
    let lines = Description::of(&path).expect("opens").lines();
    for line in [
        "Artist: an artist",
        "tag 65000: a private text",
        "LensModel: A lens",
    ] {
        assert!(lines.iter().any(|own| own.contains(line)), "{lines:?}");
    }
    // From then on nothing more is lost.
    let again = folder.path().join("c.tif");
    let plate = FlatPlate::open(&out).expect("opens");
    assert_eq!(plate.write(&again).expect("writes"), [""; 0]);
    assert!(fs::read(&again).expect("reads") == fs::read(&out).expect("reads"));
    // Where colour is in another space its white point is not kept.
    let mut plate = Plate::open(&path, &PlateOptions::default()).expect("opens");
    plate.set_colour_space("ACEScct");
    let said = plate.write(&out).expect("writes").concat();
    assert!(said.contains("`ACEScct`: WhitePoint"), "{said}");
    assert!(!tags(&out).iter().any(|tag| tag.contains("318")));
}

/// Half floats as a TIFF, laid out here: the crate writes none.
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
fn half_floats_of_tiff_stay_half_floats() {
    let folder = tempfile::tempdir().expect("a folder");
    let (path, out) = (folder.path().join("a.tif"), folder.path().join("b.tif"));
    // 1, -1.5, the largest, the smallest, infinite, nothing.
    let bits = [0x3c00, 0xbe00, 0x7bff, 0x0001, 0x7c00, 0x8000];
    write_half_tiff(&path, &bits);
    let plate = FlatPlate::open(&path).expect("opens");
    assert_eq!(plate.depth(), SampleDepth::F16);
    assert_eq!(plate.write(&out).expect("writes"), [""; 0]);
    let back = FlatPlate::open(&out).expect("opens");
    assert_eq!(back.depth(), SampleDepth::F16);
    let as_bits = |plate: &FlatPlate| -> Vec<u16> {
        let samples = plate.plane("Y").expect("Y").iter();
        samples.map(|s| half::f16::from_f32(*s).to_bits()).collect()
    };
    assert_eq!(as_bits(&back), bits);
    // What is too large is the largest, told, and known beforehand.
    let mut plate = plate;
    plate
        .replace("Y", vec![1e6, -1e6, 0.1, -3.0, f32::INFINITY, 0.0])
        .expect("six");
    let said = plate.write(&out).expect("writes");
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[0].contains("1 samples over 65504"), "{said:?}");
    let back = FlatPlate::open(&out).expect("opens");
    plate.round();
    assert_eq!(back.plane("Y"), plate.plane("Y"));
    assert_eq!(back.plane("Y").expect("Y")[..2], [65_504.0, -65_504.0]);
}
