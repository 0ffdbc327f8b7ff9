//! FITS images of two dimensions (FITS standard 4.0): in the primary part of a file or its first extension with an image, plain or
//! compressed by tiles; BZERO and BSCALE.

use std::path::Path;

use super::fits_header::{BLOCK, FULL_SCALE, Header};
use super::fits_tiles;
use super::{PhotographFile, PhotographOptions, SensorPlane, check_size};
use crate::error::{FileError, Result};

/// Extensions that are read.
const MAX_EXTENSIONS: usize = 100;

/// Reads the first image. Rows of FITS files run upwards; they are returned downwards.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    options: &PhotographOptions,
) -> Result<PhotographFile> {
    let damaged = |problem: &str| FileError::damaged(path, problem);
    let mut rest = bytes;
    let mut axes = 0;
    for extension in 0..=MAX_EXTENSIONS {
        let header = Header::parse(rest).ok_or_else(|| damaged("a header does not end"))?;
        let data = rest.get(header.length..).unwrap_or_default();
        let is_image = extension == 0 || header.text("XTENSION") == Some("IMAGE");
        let upwards = if header.text("ZIMAGE") == Some("T") {
            fits_tiles::read(path, &header, data)?
        } else if is_image && header.count("NAXIS") == 2 {
            plain(path, &header, data)?
        } else {
            if is_image {
                axes = axes.max(header.count("NAXIS"));
            }
            let length = header.data_length();
            let length = length.and_then(|v| v.checked_next_multiple_of(BLOCK));
            rest = length.and_then(|v| data.get(v..)).unwrap_or_default();
            if rest.is_empty() {
                break;
            }
            continue;
        };
        return photograph(path, upwards, options);
    }
    Err(FileError::new(
        path,
        "NAXIS",
        format!("is {axes}"),
        "give a FITS image of two dimensions, the raw mosaic of a camera",
    ))
}

/// Returns an image that is not compressed, from its lowest row.
fn plain(path: &Path, header: &Header, bytes: &[u8]) -> Result<SensorPlane> {
    let damaged = |problem: &str| FileError::damaged(path, problem);
    let (width, height) = (header.count("NAXIS1"), header.count("NAXIS2"));
    check_size(path, width, height, bytes.len())?;
    let bits = header.number("BITPIX").unwrap_or(0.0) as i64;
    let size = match bits {
        8 | 16 | 32 | -32 | -64 => bits.unsigned_abs() as usize / 8,
        _ => return Err(damaged("its BITPIX is none of 8, 16, 32, -32 and -64")),
    };
    let data = bytes
        .get(..width * height * size)
        .ok_or_else(|| damaged("pixels are missing"))?;
    let value = |b: &[u8]| match bits {
        8 => f64::from(b[0]),
        16 => f64::from(i16::from_be_bytes([b[0], b[1]])),
        32 => f64::from(i32::from_be_bytes([b[0], b[1], b[2], b[3]])),
        -32 => f64::from(f32::from_be_bytes([b[0], b[1], b[2], b[3]])),
        _ => f64::from_be_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]),
    };
    let scaled = header.scale();
    let samples = data.chunks_exact(size).map(|b| scaled(value(b)));
    Ok(SensorPlane {
        width,
        height,
        samples: samples.collect(),
        full_scale: FULL_SCALE,
    })
}

/// Returns the photograph of a plane whose first row is the lowest.
fn photograph(
    path: &Path,
    upwards: SensorPlane,
    options: &PhotographOptions,
) -> Result<PhotographFile> {
    let width = upwards.width;
    if let Some(bad) = upwards.samples.iter().position(|v| !v.is_finite()) {
        return Err(FileError::new(
            path,
            format!("pixel {}, {}", bad % width, bad / width),
            "is not a number",
            "fill blank pixels before",
        ));
    }
    let rows = upwards.samples.chunks_exact(width).rev();
    let plane = SensorPlane {
        samples: rows.flatten().copied().collect(),
        ..upwards
    };
    plane.into_photograph(path, options)
}
