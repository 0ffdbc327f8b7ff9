//! FITS images compressed by tiles with Rice codes (FITS standard 4.0, section 10), as fpack and astropy write them.

use std::path::Path;

use ricecomp::read::RCDecoder;

use super::fits_header::{FULL_SCALE, Header};
use super::{SensorPlane, check_size};
use crate::error::{FileError, Result};

/// Pixels of a Rice block where the header does not say, and the largest.
const DEFAULT_BLOCK: usize = 32;
const LARGEST_BLOCK: usize = 1 << 16;
/// Fewest bytes of a tile: those of its first pixel.
const MIN_TILE_BYTES: usize = 4;
/// Bytes of a row of the table that say the length and the place of a tile, with 32 and with 64 bits.
const SHORT_DESCRIPTOR: usize = 8;
const LONG_DESCRIPTOR: usize = 16;

/// Returns the image in a table of tiles, from its lowest row.
///
/// # Errors
/// Another compression, floats, and damaged tables.
pub(super) fn read(path: &Path, header: &Header, bytes: &[u8]) -> Result<SensorPlane> {
    let damaged = |problem: &str| FileError::damaged(path, problem);
    let unknown = |field: &str| {
        FileError::new(
            path,
            field,
            format!("is {}", header.text(field).unwrap_or("missing")),
            "unpack the image with funpack; integers of two dimensions with RICE_1 are read as they are",
        )
    };
    if !matches!(header.text("ZCMPTYPE"), Some("RICE_1" | "RICE_ONE")) {
        return Err(unknown("ZCMPTYPE"));
    }
    if header.count("ZNAXIS") != 2 {
        return Err(unknown("ZNAXIS"));
    }
    if header.count("TFIELDS") != 1 {
        return Err(unknown("TFIELDS"));
    }
    let size = match header.number("ZBITPIX").map(|v| v as i64) {
        Some(bits @ (8 | 16 | 32)) => bits as usize / 8,
        _ => return Err(unknown("ZBITPIX")),
    };
    let parameter = |name: &str| {
        let number = (1..10).find(|k| header.text(&format!("ZNAME{k}")) == Some(name))?;
        Some(header.count(&format!("ZVAL{number}")))
    };
    if parameter("BYTEPIX").is_some_and(|bytes| bytes != size) {
        return Err(damaged("BYTEPIX is not that of ZBITPIX"));
    }
    let (width, height) = (header.count("ZNAXIS1"), header.count("ZNAXIS2"));
    check_size(path, width, height, bytes.len())?;
    let side = |name: &str, default: usize| match header.count(name) {
        0 => default,
        count => count,
    };
    let tile = (side("ZTILE1", width), side("ZTILE2", 1));
    let (row_bytes, rows) = (header.count("NAXIS1"), header.count("NAXIS2"));
    let across = width.div_ceil(tile.0);
    if !matches!(row_bytes, SHORT_DESCRIPTOR | LONG_DESCRIPTOR) {
        return Err(damaged("its table has rows of another length"));
    }
    if rows != across * height.div_ceil(tile.1) {
        return Err(damaged("its table has another number of tiles"));
    }
    let heap = match header.count("THEAP") {
        0 => row_bytes.saturating_mul(rows),
        start => start,
    };
    let decoder = Decoder {
        block: match parameter("BLOCKSIZE").unwrap_or(DEFAULT_BLOCK) {
            block @ 1..=LARGEST_BLOCK => block,
            _ => return Err(damaged("its BLOCKSIZE is out of range")),
        },
        bytes_per_pixel: size,
    };
    let scaled = header.scale();
    let mut samples = vec![0.0; width * height];
    for index in 0..rows {
        let row = bytes.get(index * row_bytes..(index + 1) * row_bytes);
        let place = row.and_then(descriptor);
        let (length, start) = place.ok_or_else(|| damaged("its table of tiles is cut off"))?;
        let start = heap.saturating_add(start);
        let data = bytes.get(start..start.saturating_add(length));
        let data = data.ok_or_else(|| damaged("tiles are missing"))?;
        let (left, bottom) = (index % across * tile.0, index / across * tile.1);
        let columns = tile.0.min(width - left);
        let lines = tile.1.min(height - bottom);
        let values = decoder.values(data, columns * lines);
        let values = values.ok_or_else(|| damaged("a tile ends too early"))?;
        for (line, row) in values.chunks_exact(columns).enumerate() {
            let target = &mut samples[(bottom + line) * width + left..][..columns];
            for (sample, value) in target.iter_mut().zip(row) {
                *sample = scaled(*value);
            }
        }
    }
    Ok(SensorPlane {
        width,
        height,
        samples,
        full_scale: FULL_SCALE,
    })
}

/// Returns the length of a tile and its place in the heap, bytes.
fn descriptor(row: &[u8]) -> Option<(usize, usize)> {
    let number = |bytes: &[u8]| {
        let value = bytes.iter().fold(0_u64, |sum, b| sum << 8 | u64::from(*b));
        usize::try_from(value).ok()
    };
    let (length, place) = row.split_at(row.len() / 2);
    Some((number(length)?, number(place)?))
}

/// Decodes tiles.
struct Decoder {
    /// Pixels of a Rice block.
    block: usize,
    bytes_per_pixel: usize,
}

impl Decoder {
    /// Returns `count` values, or `None` if the tile is damaged.
    fn values(&self, data: &[u8], count: usize) -> Option<Vec<f64>> {
        if data.len() < MIN_TILE_BYTES {
            return None;
        }
        let rice = RCDecoder::new();
        match self.bytes_per_pixel {
            1 => {
                let mut out = vec![0_u8; count];
                rice.decode_byte(data, count, self.block, &mut out).ok()?;
                Some(out.into_iter().map(f64::from).collect())
            }
            2 => {
                let mut out = vec![0_u16; count];
                rice.decode_short(data, count, self.block, &mut out).ok()?;
                Some(out.into_iter().map(|v| f64::from(v as i16)).collect())
            }
            _ => {
                let mut out = vec![0_u32; count];
                rice.decode(data, count, self.block, &mut out).ok()?;
                Some(out.into_iter().map(|v| f64::from(v as i32)).collect())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_tiles_are_refused_or_read_and_never_panic() {
        let mut state = 7_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as u8
        };
        for round in 0..3000 {
            let data: Vec<u8> = (0..round % 90).map(|_| random()).collect();
            for bytes_per_pixel in [1, 2, 4] {
                let block = 1 + round % 40;
                let decoder = Decoder {
                    block,
                    bytes_per_pixel,
                };
                let values = decoder.values(&data, 100);
                assert!(values.is_none_or(|v| v.len() == 100));
            }
        }
    }
}
