//! Raw photographs: DNG (plain and lossless JPEG), PGM and FITS, composed here because the program only reads them.

use super::{HEIGHT, WIDTH, sample};

fn counts() -> Vec<u16> {
    let pixels = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    pixels
        .map(|(x, y)| 100 + (3500.0 * sample(x, y, 0)) as u16)
        .collect()
}

/// DNG files: one strip, and lossless JPEG in one tile.
pub(crate) fn dng() -> Vec<Vec<u8>> {
    let strip = counts().into_iter().flat_map(u16::to_le_bytes).collect();
    let plain = directory(&[(259, 3, 1), (278, 4, HEIGHT as u32)], [273, 279], strip);
    let tile = [(259, 3, 7), (322, 3, WIDTH as u32), (323, 3, HEIGHT as u32)];
    vec![plain, directory(&tile, [324, 325], lossless_jpeg())]
}

/// Returns a TIFF file of one directory with `more` entries (tag, type, value) and the data behind it, whose offset and
/// length go to the two tags of `place`.
fn directory(more: &[(u16, u16, u32)], place: [u16; 2], data: Vec<u8>) -> Vec<u8> {
    let mut entries: Vec<(u16, u16, u32, u32)> = vec![
        (256, 3, 1, WIDTH as u32),
        (257, 3, 1, HEIGHT as u32),
        (258, 3, 1, 16),
        (262, 3, 1, 32803),
        (277, 3, 1, 1),
        (33421, 3, 2, 2 | 2 << 16),
        (33422, 1, 4, u32::from_le_bytes([1, 0, 2, 1])),
        (50706, 1, 4, u32::from_le_bytes([1, 4, 0, 0])),
        (50714, 4, 1, 100),
        (50717, 4, 1, 4095),
    ];
    entries.extend(more.iter().map(|&(tag, kind, value)| (tag, kind, 1, value)));
    let start = 8 + 2 + 12 * (entries.len() as u32 + 2) + 4;
    entries.push((place[0], 4, 1, start));
    entries.push((place[1], 4, 1, data.len() as u32));
    entries.sort_unstable();
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(count.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0; 4]);
    bytes.extend(data);
    bytes
}

/// Encodes the counts as lossless JPEG (ITU-T T.81, process 14), each sample predicted by the one before it.
fn lossless_jpeg() -> Vec<u8> {
    let mut bytes = vec![0xff, 0xd8, 0xff, 0xc3, 0, 11, 16];
    bytes.extend((HEIGHT as u16).to_be_bytes());
    bytes.extend((WIDTH as u16).to_be_bytes());
    bytes.extend([1, 1, 0x11, 0]);
    // A Huffman table of 17 codes of five bits.
    bytes.extend([0xff, 0xc4, 0, 2 + 1 + 16 + 17, 0]);
    bytes.extend((1..=16).map(|length| if length == 5 { 17 } else { 0 }));
    bytes.extend(0..17);
    bytes.extend([0xff, 0xda, 0, 8, 1, 1, 0, 1, 0, 0]);
    let counts = counts();
    let mut bits = Vec::new();
    for (k, &count) in counts.iter().enumerate() {
        let before = match k {
            0 => 1 << 15,
            k if k % WIDTH == 0 => i32::from(counts[k - WIDTH]),
            k => i32::from(counts[k - 1]),
        };
        let difference = i32::from(count) - before;
        let size = 32 - difference.unsigned_abs().leading_zeros();
        let low = if difference < 0 {
            difference - 1
        } else {
            difference
        };
        bits.extend((0..5).rev().map(|b| size >> b & 1 == 1));
        bits.extend((0..size).rev().map(|b| low >> b & 1 == 1));
    }
    for byte in bits.chunks(8) {
        let join = |sum: u8, k: usize| sum << 1 | u8::from(*byte.get(k).unwrap_or(&true));
        let byte = (0..8).fold(0, join);
        bytes.push(byte);
        if byte == 0xff {
            bytes.push(0);
        }
    }
    bytes.extend([0xff, 0xd9]);
    bytes
}

/// PGM of 16 bits, with a comment.
pub(crate) fn pgm() -> Vec<Vec<u8>> {
    let mut bytes = format!("P5\n# a comment\n{WIDTH} {HEIGHT}\n65535\n").into_bytes();
    bytes.extend(counts().into_iter().flat_map(u16::to_be_bytes));
    vec![bytes]
}

/// FITS of 16-bit integers, of floats, and of integers compressed by tiles.
pub(crate) fn fits() -> Vec<Vec<u8>> {
    vec![fits_of(16), fits_of(-32), fits_of_tiles()]
}

/// Returns the blocks of a FITS header with `cards`.
fn fits_header(cards: &[(&str, String)]) -> Vec<u8> {
    let mut text: String = cards
        .iter()
        .map(|(name, value)| format!("{:80}", format!("{name:8}= {value:>20}")))
        .collect();
    text += &format!("{:80}", "END");
    let length = text.len().div_ceil(2880) * 2880;
    format!("{text:length$}").into_bytes()
}

/// An extension with a tile for each row. Rice codes of zeros alone say that all pixels are zero.
fn fits_of_tiles() -> Vec<u8> {
    const TILE_BYTES: u32 = 16;
    let mut bytes = fits_header(&[
        ("SIMPLE", "T".to_owned()),
        ("BITPIX", "8".to_owned()),
        ("NAXIS", "0".to_owned()),
    ]);
    let rows = HEIGHT as u32;
    bytes.extend(fits_header(&[
        ("XTENSION", "'BINTABLE'".to_owned()),
        ("BITPIX", "8".to_owned()),
        ("NAXIS", "2".to_owned()),
        ("NAXIS1", "8".to_owned()),
        ("NAXIS2", rows.to_string()),
        ("PCOUNT", (TILE_BYTES * rows).to_string()),
        ("TFIELDS", "1".to_owned()),
        ("ZIMAGE", "T".to_owned()),
        ("ZCMPTYPE", "'RICE_1'".to_owned()),
        ("ZBITPIX", "16".to_owned()),
        ("ZNAXIS", "2".to_owned()),
        ("ZNAXIS1", WIDTH.to_string()),
        ("ZNAXIS2", HEIGHT.to_string()),
        ("BZERO", "32768".to_owned()),
    ]));
    for row in 0..rows {
        bytes.extend(TILE_BYTES.to_be_bytes());
        bytes.extend((TILE_BYTES * row).to_be_bytes());
    }
    bytes.extend(vec![0; (TILE_BYTES * rows) as usize]);
    bytes
}

fn fits_of(bits: i32) -> Vec<u8> {
    let mut bytes = fits_header(&[
        ("SIMPLE", "T".to_owned()),
        ("BITPIX", bits.to_string()),
        ("NAXIS", "2".to_owned()),
        ("NAXIS1", WIDTH.to_string()),
        ("NAXIS2", HEIGHT.to_string()),
        ("BZERO", "0".to_owned()),
        ("BSCALE", "1".to_owned()),
    ]);
    for count in counts() {
        if bits == 16 {
            bytes.extend((count as i16).to_be_bytes());
        } else {
            bytes.extend(f32::from(count).to_be_bytes());
        }
    }
    bytes
}
