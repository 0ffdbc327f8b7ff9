//! Photographs: DNG in all its forms, mosaics in other files, levels, and refusals.

use std::path::{Path, PathBuf};

use seidel_optics::mosaic::Mosaic;

use crate::description::Description;
use crate::photograph::{ColourFilter, PhotographOptions, Precision, encode_lossless, read};
use crate::samples::Encoding;

const WIDTH: usize = 12;
const HEIGHT: usize = 8;

/// A small DNG file.
struct Dng {
    big_endian: bool,
    entries: Vec<(u16, u16, Vec<u32>)>,
    data: Vec<Vec<u8>>,
}

impl Dng {
    /// Uncompressed 16-bit samples in one strip.
    fn new(samples: &[u16]) -> Self {
        let bytes = samples.iter().flat_map(|s| s.to_le_bytes()).collect();
        let size = (WIDTH as u32, HEIGHT as u32);
        let entries = vec![
            (256, 3, vec![size.0]),
            (257, 3, vec![size.1]),
            (258, 3, vec![16]),
            (259, 3, vec![1]),
            (262, 3, vec![32803]),
            (277, 3, vec![1]),
            (278, 4, vec![size.1]),
            (33421, 3, vec![2, 2]),
            (33422, 1, vec![1, 0, 2, 1]),
            (50706, 1, vec![1, 4, 0, 0]),
            (50714, 4, vec![100]),
            (50717, 4, vec![4095]),
        ];
        Self {
            big_endian: false,
            entries,
            data: vec![bytes],
        }
    }

    fn set(mut self, tag: u16, kind: u16, values: Vec<u32>) -> Self {
        self.entries.retain(|e| e.0 != tag);
        self.entries.push((tag, kind, values));
        self
    }

    fn bytes(&self) -> Vec<u8> {
        let put = |value: u32, size: usize| -> Vec<u8> {
            if self.big_endian {
                value.to_be_bytes()[4 - size..].to_vec()
            } else {
                value.to_le_bytes()[..size].to_vec()
            }
        };
        let is_tiled = self.entries.iter().any(|e| e.0 == 322);
        let (offsets, lengths) = if is_tiled { (324, 325) } else { (273, 279) };
        let mut entries = self.entries.clone();
        let mut at = 8;
        let mut places = Vec::new();
        for data in &self.data {
            places.push(at as u32);
            at += data.len() + data.len() % 2;
        }
        entries.push((offsets, 4, places));
        entries.push((
            lengths,
            4,
            self.data.iter().map(|d| d.len() as u32).collect(),
        ));
        entries.sort_by_key(|e| e.0);
        let mut out = if self.big_endian {
            b"MM".to_vec()
        } else {
            b"II".to_vec()
        };
        out.extend(put(42, 2));
        out.extend(put(at as u32, 4));
        for data in &self.data {
            out.extend(data);
            out.resize(out.len() + data.len() % 2, 0);
        }
        let mut beyond = at + 2 + 12 * entries.len() + 4;
        let mut tail = Vec::new();
        out.extend(put(entries.len() as u32, 2));
        for (tag, kind, values) in &entries {
            let size = match kind {
                1 => 1,
                3 => 2,
                _ => 4,
            };
            let mut bytes: Vec<u8> = values.iter().flat_map(|v| put(*v, size)).collect();
            out.extend(put(u32::from(*tag), 2));
            out.extend(put(u32::from(*kind), 2));
            out.extend(put(values.len() as u32, 4));
            if bytes.len() <= 4 {
                bytes.resize(4, 0);
                out.extend(bytes);
            } else {
                out.extend(put(beyond as u32, 4));
                beyond += bytes.len();
                tail.extend(bytes);
            }
        }
        out.extend(put(0, 4));
        out.extend(tail);
        out
    }
}

fn samples() -> Vec<u16> {
    (0..WIDTH * HEIGHT)
        .map(|k| (100 + 37 * k % 3900) as u16)
        .collect()
}

fn expected() -> Vec<f32> {
    samples().iter().map(|s| f32::from(*s) - 100.0).collect()
}

fn put(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).expect("writes");
    path
}

fn refused(path: &Path, options: &PhotographOptions) -> String {
    read(path, options).expect_err("a bad file").to_string()
}

#[test]
fn dng_of_every_layout_gives_the_same_counts() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let none = PhotographOptions::default();
    let samples = samples();
    let plain = Dng::new(&samples);
    let mut swapped = Dng::new(&samples);
    swapped.big_endian = true;
    swapped.data = vec![samples.iter().flat_map(|s| s.to_be_bytes()).collect()];
    // 8 x 4 tiles, which reach beyond the image on the right, as two components of half the width.
    let tile = |left: usize, top: usize| -> Vec<u8> {
        let at = |k: usize| {
            let (x, y) = (left + k % 8, top + k / 8);
            samples
                .get(y * WIDTH + x)
                .copied()
                .filter(|_| x < WIDTH)
                .unwrap_or(0)
        };
        encode_lossless(&(0..32).map(at).collect::<Vec<_>>(), 4, 2)
    };
    let mut tiled = Dng::new(&samples)
        .set(259, 3, vec![7])
        .set(322, 3, vec![8])
        .set(323, 3, vec![4]);
    tiled.data = vec![tile(0, 0), tile(8, 0), tile(0, 4), tile(8, 4)];
    let mut packed = Dng::new(&samples).set(258, 3, vec![12]);
    let pairs = samples.chunks_exact(2);
    packed.data = vec![
        pairs
            .flat_map(|p| {
                [
                    (p[0] >> 4) as u8,
                    (p[0] << 4) as u8 | (p[1] >> 8) as u8,
                    p[1] as u8,
                ]
            })
            .collect(),
    ];
    for (name, dng) in [("a", plain), ("b", swapped), ("c", tiled), ("d", packed)] {
        let path = put(folder, name, &dng.bytes());
        let photograph = read(&path, &none).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(photograph.planes, [expected()], "{name}");
        assert_eq!(photograph.mosaic.expect("a mosaic").to_string(), "GRBG");
        assert_eq!((photograph.width, photograph.height), (WIDTH, HEIGHT));
        assert!(
            (3900.0..3995.0).contains(&photograph.white),
            "{}",
            photograph.white
        );
        assert_eq!(photograph.precision, Precision::Linear);
    }
}

#[test]
fn levels_tables_and_the_active_area_are_applied() {
    let folder = tempfile::tempdir().expect("a folder");
    let none = PhotographOptions::default();
    let samples = samples();
    let area = Dng::new(&samples)
        .set(50829, 3, vec![1, 3, 7, 11])
        .set(50713, 3, vec![2, 2])
        .set(50714, 4, vec![100, 90, 80, 70]);
    let path = put(folder.path(), "area.dng", &area.bytes());
    let photograph = read(&path, &none).expect("valid");
    assert_eq!((photograph.width, photograph.height), (8, 6));
    // The pattern and the levels begin at the corner of the active area.
    assert_eq!(photograph.mosaic.expect("a mosaic").to_string(), "GRBG");
    let stored = |x: usize, y: usize| f32::from(samples[(y + 1) * WIDTH + x + 3]);
    assert_eq!(photograph.planes[0][0], stored(0, 0) - 100.0);
    assert_eq!(photograph.planes[0][1], stored(1, 0) - 90.0);
    assert_eq!(photograph.planes[0][8], stored(0, 1) - 80.0);
    assert_eq!(photograph.planes[0][9], stored(1, 1) - 70.0);

    let table: Vec<u32> = (0..4096).map(|v| 2 * v).collect();
    let curved = Dng::new(&samples)
        .set(50712, 3, table)
        .set(50714, 4, vec![200])
        .set(50717, 4, vec![8190]);
    let path = put(folder.path(), "table.dng", &curved.bytes());
    let photograph = read(&path, &none).expect("valid");
    let doubled: Vec<f32> = expected().iter().map(|v| 2.0 * v).collect();
    assert_eq!(photograph.planes[0], doubled);

    let stated = PhotographOptions {
        black: Some(60.0),
        white: Some(1060.0),
        cfa: Some(ColourFilter::Mosaic(
            Mosaic::parse("BGGR").expect("a pattern"),
        )),
        ..none
    };
    let path = put(folder.path(), "plain.dng", &Dng::new(&samples).bytes());
    let photograph = read(&path, &stated).expect("valid");
    assert_eq!(photograph.planes[0][0], f32::from(samples[0]) - 60.0);
    assert_eq!(photograph.white, 998.0);
    assert_eq!(photograph.mosaic.expect("a mosaic").to_string(), "BGGR");
}

#[test]
fn differences_of_black_and_the_white_of_each_channel_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let none = PhotographOptions::default();
    let samples = samples();
    let rows: Vec<u32> = (0..HEIGHT as u32).map(|y| 50 + y).collect();
    let columns: Vec<u32> = (0..WIDTH as u32).map(|x| 40 + x).collect();
    let deltas = Dng::new(&samples)
        .set(50714, 3, vec![10])
        .set(50715, 3, columns)
        .set(50716, 3, rows);
    let photograph = read(&put(folder.path(), "delta.dng", &deltas.bytes()), &none).expect("valid");
    let black = |x: usize, y: usize| (10 + 50 + y + 40 + x) as f32;
    for (x, y) in [(0, 0), (3, 2), (WIDTH - 1, HEIGHT - 1)] {
        let k = y * WIDTH + x;
        let linear = f32::from(samples[k]) - black(x, y);
        assert_eq!(photograph.planes[0][k], linear, "{x}, {y}");
    }
    // Clipped samples are at or above the level, whatever the black of their row and column.
    let bright = vec![4000; WIDTH * HEIGHT];
    let levels = [
        (50714, vec![10]),
        (50715, (0..WIDTH as u32).map(|x| 40 * x).collect()),
        (50717, vec![4000]),
    ];
    let clipped = (levels.into_iter()).fold(Dng::new(&bright), |dng, (tag, values)| {
        dng.set(tag, 3, values)
    });
    let photograph = read(&put(folder.path(), "clip.dng", &clipped.bytes()), &none).expect("valid");
    assert!(photograph.planes[0].iter().all(|v| *v >= photograph.white));

    // Linear colour whose green clips at 2000.
    let pixels: Vec<u16> = (0..WIDTH * HEIGHT).flat_map(|_| [2000; 3]).collect();
    let linear = Dng::new(&pixels)
        .set(262, 3, vec![34892])
        .set(277, 3, vec![3])
        .set(258, 3, vec![16; 3])
        .set(50714, 3, vec![0; 3])
        .set(50717, 3, vec![4056, 2000, 4056]);
    let photograph = read(&put(folder.path(), "white.dng", &linear.bytes()), &none).expect("valid");
    let is_clipped = photograph
        .planes
        .iter()
        .map(|plane| plane[0] >= photograph.white);
    assert_eq!(is_clipped.collect::<Vec<_>>(), [false, true, false]);
    let doubtful = Dng::new(&samples).set(50714, 3, vec![10, 20, 20, 30]);
    let photograph =
        read(&put(folder.path(), "four.dng", &doubtful.bytes()), &none).expect("valid");
    assert!(
        photograph
            .warnings
            .concat()
            .contains("BlackLevel has 4 values")
    );
}

#[test]
fn the_primary_image_is_read_beside_a_larger_enhanced_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let none = PhotographOptions::default();
    let samples = samples();
    let mut bytes = Dng::new(&samples).bytes();
    let at =
        |bytes: &[u8], at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"));
    let first = at(&bytes, 4) as usize;
    let count = usize::from(u16::from_le_bytes([bytes[first], bytes[first + 1]]));
    let second = (bytes.len() as u32).to_le_bytes();
    bytes[first + 2 + 12 * count..][..4].copy_from_slice(&second);
    // An enhanced image of one row of 1000 pixels: type 16, linear.
    let entries: [(u16, u32); 8] = [
        (254, 16),
        (256, 1000),
        (257, 1),
        (258, 16),
        (262, 34892),
        (273, 8),
        (277, 1),
        (279, 100),
    ];
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, value) in entries {
        bytes.extend(
            [
                &tag.to_le_bytes()[..],
                &[4, 0, 1, 0, 0, 0],
                &value.to_le_bytes(),
            ]
            .concat(),
        );
    }
    bytes.extend([0; 4]);
    let photograph = read(&put(folder.path(), "enhanced.dng", &bytes), &none).expect("valid");
    assert_eq!((photograph.width, photograph.height), (WIDTH, HEIGHT));
    assert!(photograph.mosaic.is_some());
}

#[test]
fn camera_raw_is_no_plate() {
    let folder = tempfile::tempdir().expect("a folder");
    let samples = samples();
    // A mosaic, and a preview in the first place.
    let preview = Dng::new(&samples).set(262, 3, vec![1]);
    for (name, bytes) in [
        ("mosaic.dng", Dng::new(&samples).bytes()),
        ("preview.dng", preview.bytes()),
        ("preview.tif", preview.bytes()),
    ] {
        let path = put(folder.path(), name, &bytes);
        let text = Description::read(&path).expect_err("raw").to_string();
        assert!(text.contains("seidel measure"), "{name}: {text}");
    }
}

#[test]
fn damaged_and_unsupported_dng_files_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let none = PhotographOptions::default();
    let samples = samples();
    let bytes = Dng::new(&samples).bytes();
    for length in [4, 8, 100, bytes.len() / 2, bytes.len() - 40] {
        let path = put(folder, "cut.dng", &bytes[..length]);
        let text = refused(&path, &none);
        assert!(text.contains("damaged or truncated"), "{length}: {text}");
    }
    let huge = Dng::new(&samples).set(256, 4, vec![4_000_000_000]);
    let text = refused(&put(folder, "huge.dng", &huge.bytes()), &none);
    assert!(text.contains("claims"), "{text}");
    let missing = Dng::new(&samples)
        .set(257, 3, vec![500])
        .set(278, 4, vec![500]);
    let text = refused(&put(folder, "missing.dng", &missing.bytes()), &none);
    assert!(text.contains("samples are missing"), "{text}");
    let lossy = Dng::new(&samples).set(259, 3, vec![34892]);
    let text = refused(&put(folder, "lossy.dng", &lossy.bytes()), &none);
    assert!(
        text.contains("Compression: is 34892") && text.contains("dnglab"),
        "{text}"
    );
    let trans = Dng::new(&samples).set(33421, 3, vec![6, 6]);
    let text = refused(&put(folder, "trans.dng", &trans.bytes()), &none);
    assert!(text.contains("CFAPattern"), "{text}");
    let text = refused(&put(folder, "a.nef", &bytes), &none);
    assert!(
        text.contains("Nikon NEF") && text.contains("dcraw -D -4 -T"),
        "{text}"
    );
}

/// Returns the block of a FITS header with `cards`.
fn fits_header(cards: &[&str]) -> Vec<u8> {
    let mut header = Vec::new();
    for card in cards.iter().chain(&["END"]) {
        header.extend(format!("{card:80}").into_bytes());
    }
    header.resize(2880, b' ');
    header
}

/// Returns a FITS file with `samples` in the first extension, compressed in tiles of 7 x 3 pixels.
fn fits_of_tiles(samples: &[u16]) -> Vec<u8> {
    let (tile_width, tile_height) = (7, 3);
    let height = samples.len() / WIDTH;
    let upwards: Vec<&[u16]> = samples.chunks_exact(WIDTH).rev().collect();
    let (mut table, mut heap) = (Vec::new(), Vec::new());
    for bottom in (0..height).step_by(tile_height) {
        for left in (0..WIDTH).step_by(tile_width) {
            let rows = &upwards[bottom..(bottom + tile_height).min(height)];
            let columns = left..(left + tile_width).min(WIDTH);
            let values: Vec<i16> = (rows.iter())
                .flat_map(|row| row[columns.clone()].iter())
                .map(|s| (i32::from(*s) - 32768) as i16)
                .collect();
            let mut tile = Vec::new();
            ricecomp::write::RCEncoder::new(&mut tile)
                .encode_short(&values, values.len(), 16)
                .expect("encodes");
            for number in [tile.len(), heap.len()] {
                table.extend((number as u32).to_be_bytes());
            }
            heap.extend(tile);
        }
    }
    let rows = table.len() / 8;
    let mut file = fits_header(&["SIMPLE  = T", "BITPIX  = 8", "NAXIS   = 0"]);
    let counts = [
        format!("NAXIS2  = {rows}"),
        format!("PCOUNT  = {}", heap.len()),
    ];
    file.extend(fits_header(&[
        "XTENSION= 'BINTABLE'",
        "BITPIX  = 8",
        "NAXIS   = 2",
        "NAXIS1  = 8",
        &counts[0],
        &counts[1],
        "TFIELDS = 1",
        "TFORM1  = '1PB(60)'",
        "ZIMAGE  = T",
        "ZCMPTYPE= 'RICE_1  '",
        "ZBITPIX = 16",
        "ZNAXIS  = 2",
        "ZNAXIS1 = 12",
        "ZNAXIS2 = 8",
        "ZTILE1  = 7",
        "ZTILE2  = 3",
        "ZNAME1  = 'BLOCKSIZE'",
        "ZVAL1   = 16",
        "ZNAME2  = 'BYTEPIX '",
        "ZVAL2   = 2",
        "BZERO   = 32768",
    ]));
    file.extend(table);
    file.extend(heap);
    file
}

#[test]
fn mosaics_in_pgm_fits_and_tiff_need_a_pattern() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let samples = samples();
    let mut pgm = format!("P5\n# made by hand\n{WIDTH} {HEIGHT}\n65535\n").into_bytes();
    pgm.extend(samples.iter().flat_map(|s| s.to_be_bytes()));
    let mut fits = fits_header(&[
        "SIMPLE  =                    T",
        "BITPIX  =                   16",
        "NAXIS   =                    2",
        "NAXIS1  =                   12 / columns",
        "NAXIS2  =                    8",
        "BZERO   =                32768",
        "BSCALE  =                    1",
    ]);
    for row in samples.chunks_exact(WIDTH).rev() {
        fits.extend(
            row.iter()
                .flat_map(|s| ((i32::from(*s) - 32768) as i16).to_be_bytes()),
        );
    }
    let tiff = Dng::new(&samples)
        .set(262, 3, vec![1])
        .set(50706, 1, vec![])
        .bytes();
    let none = PhotographOptions::default();
    let stated = PhotographOptions {
        cfa: Some(ColourFilter::Mosaic(
            Mosaic::parse("RGGB").expect("a pattern"),
        )),
        black: Some(100.0),
        ..none
    };
    let files = [
        ("a.pgm", pgm),
        ("a.fits", fits),
        ("tiles.fits", fits_of_tiles(&samples)),
        ("a.tif", tiff),
    ];
    for (name, bytes) in files {
        let path = put(folder, name, &bytes);
        let text = refused(&path, &none);
        assert!(text.contains("--cfa RGGB"), "{name}: {text}");
        let photograph = read(&path, &stated).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(photograph.planes, [expected()], "{name}");
        assert!(photograph.warnings[0].contains("--white"), "{name}");
        let cut = put(folder, name, &bytes[..bytes.len() - bytes.len() / 3]);
        let text = refused(&cut, &stated);
        assert!(text.contains("damaged or truncated"), "{name}: {text}");
    }
}

#[test]
fn a_fits_header_with_absurd_axes_is_refused_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let header = fits_header(&["SIMPLE  = T", "BITPIX  = 8", "NAXIS   = 4e18"]);
    let path = put(folder.path(), "a.fits", &[header, vec![0; 2880]].concat());
    let text = refused(&path, &PhotographOptions::default());
    assert!(text.contains("two dimensions"), "{text}");
}

#[test]
fn developments_are_decoded_with_a_warning_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let none = PhotographOptions::default();
    let path = folder.path().join("a.png");
    let picture =
        image::RgbImage::from_fn(6, 4, |x, y| image::Rgb([x as u8 * 40, y as u8 * 60, 255]));
    picture.save(&path).expect("writes");
    let photograph = read(&path, &none).expect("valid");
    assert_eq!(photograph.precision, Precision::EightBit);
    assert!(photograph.warnings.iter().any(|w| w.contains("sRGB")));
    let code = Encoding::Srgb.decode(200.0 / 255.0) * 255.0;
    assert!((photograph.planes[0][5] - code).abs() < 1e-3);
    assert!(
        photograph.planes[2][0] > photograph.white,
        "white is clipped"
    );

    let path = folder.path().join("b.png");
    let deep = image::ImageBuffer::from_fn(6, 4, |x, _| image::Rgb([x as u16 * 9000, 7, 9]));
    deep.save(&path).expect("writes");
    let text = refused(&path, &none);
    assert!(text.contains("--encoding linear"), "{text}");
    let linear = PhotographOptions {
        encoding: Some(Encoding::Linear),
        ..none
    };
    let photograph = read(&path, &linear).expect("valid");
    assert_eq!(photograph.planes[0][3].round(), 27000.0);
    assert!(photograph.warnings.is_empty());
}
