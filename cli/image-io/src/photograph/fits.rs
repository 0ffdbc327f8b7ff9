//! FITS images of two dimensions (FITS standard 4.0): cards of the primary header, BZERO and BSCALE.

use std::path::Path;

use super::{PhotographFile, PhotographOptions, SensorPlane, check_size};
use crate::error::{FileError, Result};

/// Length of a block of the file, and of a header card, bytes.
const BLOCK: usize = 2880;
const CARD: usize = 80;
/// Cards of a header that are read.
const MAX_CARDS: usize = 36 * 1000;

/// Reads the primary image. Rows of FITS files run upwards; they are returned downwards.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    options: &PhotographOptions,
) -> Result<PhotographFile> {
    let damaged = |problem: &str| FileError::damaged(path, problem);
    let mut cards = Vec::new();
    let mut length = None;
    for (k, card) in bytes.chunks_exact(CARD).take(MAX_CARDS).enumerate() {
        let text = String::from_utf8_lossy(card);
        let key = text.get(..8).unwrap_or_default().trim().to_owned();
        if key == "END" {
            length = Some((k + 1) * CARD);
            break;
        }
        let value = text.get(10..).unwrap_or_default();
        let value = value.split('/').next().unwrap_or_default().trim();
        cards.push((key, value.parse::<f64>().ok()));
    }
    let header = length.ok_or_else(|| damaged("its header does not end"))?;
    let number = |name: &str| {
        cards
            .iter()
            .find(|(key, _)| key == name)
            .and_then(|(_, v)| *v)
    };
    let whole = |name: &str| number(name).filter(|v| *v >= 0.0).map_or(0, |v| v as usize);
    if whole("NAXIS") != 2 {
        return Err(FileError::new(
            path,
            "NAXIS",
            format!("is {}", whole("NAXIS")),
            "give a FITS image of two dimensions, the raw mosaic of a camera",
        ));
    }
    let (width, height) = (whole("NAXIS1"), whole("NAXIS2"));
    check_size(path, width, height, bytes.len())?;
    let bits = number("BITPIX").unwrap_or(0.0) as i64;
    let size = match bits {
        8 | 16 | 32 | -32 | -64 => bits.unsigned_abs() as usize / 8,
        _ => return Err(damaged("its BITPIX is none of 8, 16, 32, -32 and -64")),
    };
    let start = header.div_ceil(BLOCK) * BLOCK;
    let data = bytes
        .get(start..start + width * height * size)
        .ok_or_else(|| damaged("pixels are missing"))?;
    let (zero, scale) = (
        number("BZERO").unwrap_or(0.0),
        number("BSCALE").unwrap_or(1.0),
    );
    let value = |b: &[u8]| match bits {
        8 => f64::from(b[0]),
        16 => f64::from(i16::from_be_bytes([b[0], b[1]])),
        32 => f64::from(i32::from_be_bytes([b[0], b[1], b[2], b[3]])),
        -32 => f64::from(f32::from_be_bytes([b[0], b[1], b[2], b[3]])),
        _ => f64::from_be_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]),
    };
    let upwards: Vec<f32> = (data.chunks_exact(size))
        .map(|b| (zero + scale * value(b)) as f32)
        .collect();
    if let Some(bad) = upwards.iter().position(|v| !v.is_finite()) {
        return Err(FileError::new(
            path,
            format!("pixel {}, {}", bad % width, bad / width),
            "is not a number",
            "fill blank pixels before",
        ));
    }
    let rows = upwards.chunks_exact(width).rev();
    let plane = SensorPlane {
        width,
        height,
        samples: rows.flatten().copied().collect(),
        full_scale: 65535.0,
    };
    plane.into_photograph(path, options)
}
