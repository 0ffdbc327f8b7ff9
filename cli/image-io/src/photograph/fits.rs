//! FITS images of two dimensions (FITS standard 4.0): in the primary part of a file or its first extension with an image, plain or
//! compressed by tiles; BZERO and BSCALE.

use std::path::Path;

use super::fits_tiles;
use super::{PhotographFile, PhotographOptions, SensorPlane, check_size};
use crate::error::{FileError, Result};

/// Length of a block of the file, and of a header card, bytes.
const BLOCK: usize = 2880;
const CARD: usize = 80;
/// Cards of a header, and extensions, that are read.
const MAX_CARDS: usize = 36 * 1000;
const MAX_EXTENSIONS: usize = 100;
/// Largest number of axes that the standard allows.
const MAX_AXES: usize = 999;
/// Largest sample of 16 bits, the clipping level where the caller states none.
pub(super) const FULL_SCALE: f32 = 65535.0;

/// The cards of a header.
pub(super) struct Header {
    cards: Vec<(String, String)>,
    /// Length of the header with its padding, bytes.
    length: usize,
}

impl Header {
    /// Reads the header at the start of `bytes`; `None` if it does not end.
    fn parse(bytes: &[u8]) -> Option<Self> {
        let mut cards = Vec::new();
        for (k, card) in bytes.chunks_exact(CARD).take(MAX_CARDS).enumerate() {
            let text = String::from_utf8_lossy(card);
            let key = text.get(..8).unwrap_or_default().trim().to_owned();
            if key == "END" {
                let length = ((k + 1) * CARD).div_ceil(BLOCK) * BLOCK;
                return Some(Self { cards, length });
            }
            let value = text.get(10..).unwrap_or_default();
            let value = value.split('/').next().unwrap_or_default().trim();
            cards.push((key, value.to_owned()));
        }
        None
    }

    /// Returns the value of card `name` without quotation marks.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        let (_, value) = self.cards.iter().find(|(key, _)| key == name)?;
        Some(value.trim_matches('\'').trim())
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.text(name)?.parse().ok()
    }

    /// Returns the value of card `name` as a count; zero if there is none.
    pub(super) fn count(&self, name: &str) -> usize {
        self.number(name)
            .filter(|v| *v >= 0.0)
            .map_or(0, |v| v as usize)
    }

    /// Returns the length of the data behind the header without padding, bytes; `None` if it is too large to count.
    fn data_length(&self) -> Option<usize> {
        let axes = self.count("NAXIS");
        if axes > MAX_AXES {
            return None;
        }
        let mut length = usize::from(axes > 0);
        for axis in 1..=axes {
            length = length.checked_mul(self.count(&format!("NAXIS{axis}")))?;
        }
        let sample = self.number("BITPIX").unwrap_or(0.0).abs() as usize / 8;
        length
            .checked_mul(sample)?
            .checked_add(self.count("PCOUNT"))
    }
}

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
    let scaled = scale(header);
    let samples = data.chunks_exact(size).map(|b| scaled(value(b)));
    Ok(SensorPlane {
        width,
        height,
        samples: samples.collect(),
        full_scale: FULL_SCALE,
    })
}

/// Returns the function from stored values to samples.
pub(super) fn scale(header: &Header) -> impl Fn(f64) -> f32 {
    let zero = header.number("BZERO").unwrap_or(0.0);
    let scale = header.number("BSCALE").unwrap_or(1.0);
    move |value| (zero + scale * value) as f32
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
