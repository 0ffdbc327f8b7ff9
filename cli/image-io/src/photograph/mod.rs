//! Photographs as linear counts above black, for measurement: raw mosaics without any interpolation, and linear images.
//!
//! | file | read as |
//! | --- | --- |
//! | DNG | a mosaic or linear raw image, with the levels that the file states |
//! | TIFF, PNG, PGM of one channel with 16 bits | a mosaic whose pattern the caller states, or a monochrome image |
//! | FITS of two dimensions, plain or compressed by tiles with Rice codes | the same |
//! | OpenEXR, and float TIFF | linear channels |
//! | other images | channels decoded as the caller states; 8-bit ones with a warning |

mod camera;
mod developed;
mod directory;
mod dng;
mod fits;
mod fits_header;
mod fits_tiles;
mod foreign;
mod lossless_jpeg;
mod pgm;

#[cfg(test)]
pub(crate) use lossless_jpeg::tests::encode as encode_lossless;

pub use camera::{StatedCamera, stated_camera};

use std::path::Path;

use seidel_optics::mosaic::Mosaic;

use crate::error::{FileError, Result};
use crate::input::{Limits, open_file};
use crate::json::read_bytes;
use crate::samples::Encoding;

/// Length of the longest file that is read, bytes.
const FILE_LIMIT_BYTES: u64 = 2 << 30;
/// The share of the range below white that counts as clipped, and its least value in counts: sensors scatter there.
const CLIPPED_SHARE: f32 = 0.002;
const CLIPPED_COUNTS: f32 = 2.0;

/// Properties of photographs that the caller states because their files may not.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PhotographOptions {
    /// The colour filter mosaic.
    pub cfa: Option<ColourFilter>,
    /// The black level, counts.
    pub black: Option<f32>,
    /// The level at which samples clip, counts.
    pub white: Option<f32>,
    /// The transfer function of samples.
    pub encoding: Option<Encoding>,
}

/// A colour filter mosaic, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColourFilter {
    /// No mosaic: every pixel has every channel.
    None,
    /// A repeating block of 2 x 2 colours.
    Mosaic(Mosaic),
}

/// The precision of the samples, from which errors follow that noise does not show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Linear samples as the sensor gave them, or floats.
    Linear,
    /// A development with a transfer function, and interpolated colours.
    Developed,
    /// The same with 8 bits.
    EightBit,
}

/// A photograph in counts above black.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotographFile {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// One plane for a mosaic, otherwise one for each channel; row-major.
    pub planes: Vec<Vec<f32>>,
    /// Channel names.
    pub channels: Vec<String>,
    /// The mosaic of a raw photograph.
    pub mosaic: Option<Mosaic>,
    /// Counts from which on a pixel is clipped; infinite if unknown.
    pub white: f32,
    /// Counts per electron, if the file states its noise.
    pub gain: Option<f64>,
    /// Stored value of the code 1, by which a transfer function scales codes; `None` for raw photographs.
    pub code_scale: Option<f32>,
    /// Precision of the samples.
    pub precision: Precision,
    /// Remarks on what was assumed.
    pub warnings: Vec<String>,
}

/// Reads a photograph.
///
/// # Errors
/// A file that cannot be read, is damaged or in no supported format; a mosaic without a pattern; an integer image whose
/// transfer function is not known.
pub fn read(path: &Path, options: &PhotographOptions) -> Result<PhotographFile> {
    let mut start = [0; 16];
    let length = read_start(path, &mut start)?;
    let start = &start[..length];
    let extension = extension(path);
    if let Some(error) = foreign::refuse(path, start, &extension) {
        return Err(error);
    }
    let is_tiff = start.starts_with(b"II*\0") || start.starts_with(b"MM\0*");
    if is_tiff {
        let bytes = read_bytes(path, FILE_LIMIT_BYTES)?;
        if let Some(photograph) = dng::read(path, &bytes, options)? {
            return Ok(photograph);
        }
    }
    if start.starts_with(b"P5") {
        return pgm::read(path, &read_bytes(path, FILE_LIMIT_BYTES)?, options);
    }
    if start.starts_with(b"SIMPLE  =") {
        return fits::read(path, &read_bytes(path, FILE_LIMIT_BYTES)?, options);
    }
    developed::read(path, options)
}

fn read_start(path: &Path, start: &mut [u8; 16]) -> Result<usize> {
    use std::io::Read;
    let file = open_file(path)?;
    let mut bytes = Vec::new();
    file.take(start.len() as u64)
        .read_to_end(&mut bytes)
        .map_err(|e| FileError::io(path, "be read", &e))?;
    if bytes.is_empty() {
        return Err(FileError::new(path, "", "is empty", "copy the file again"));
    }
    start[..bytes.len()].copy_from_slice(&bytes);
    Ok(bytes.len())
}

fn extension(path: &Path) -> String {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.unwrap_or_default().to_ascii_lowercase()
}

/// Integer samples of one plane, as a file stores them, with the levels it states.
struct SensorPlane {
    width: usize,
    height: usize,
    samples: Vec<f32>,
    /// Largest value that the file can store.
    full_scale: f32,
}

impl SensorPlane {
    /// Returns the photograph with the pattern and the levels that the caller states.
    fn into_photograph(self, path: &Path, options: &PhotographOptions) -> Result<PhotographFile> {
        let Some(filter) = options.cfa else {
            return Err(FileError::new(
                path,
                "",
                "has one channel and does not say which colours its pixels have",
                "give --cfa with the top-left 2 x 2 pixels, such as --cfa RGGB, or --cfa none for a monochrome sensor",
            ));
        };
        let (mosaic, channels) = match filter {
            ColourFilter::None => (None, vec!["Y".to_owned()]),
            ColourFilter::Mosaic(mosaic) => (Some(mosaic), rgb()),
        };
        let mut warnings = Vec::new();
        let black = options.black.unwrap_or_else(|| {
            warnings.push(format!(
                "{}: the black level is not known and taken as 0; give --black if it is not",
                path.display()
            ));
            0.0
        });
        let largest = self.samples.iter().copied().fold(0.0, f32::max);
        let white = options.white.unwrap_or_else(|| {
            // A sensor of 12 or 14 bits clips below the full scale of the file.
            let bits = (largest + 1.0).log2().ceil().max(8.0);
            let level = (bits.exp2() - 1.0).min(self.full_scale);
            warnings.push(format!(
                "{}: the clipping level is not known and taken as {level}; give --white if it is not",
                path.display()
            ));
            level
        });
        Ok(PhotographFile {
            width: self.width,
            height: self.height,
            planes: vec![self.samples.iter().map(|v| v - black).collect()],
            channels,
            mosaic,
            white: clipping_level(black, white),
            gain: None,
            code_scale: None,
            precision: Precision::Linear,
            warnings,
        })
    }
}

/// Returns the counts above `black` from which on a pixel counts as clipped.
pub fn clipping_level(black: f32, white: f32) -> f32 {
    let range = white - black;
    range - (CLIPPED_SHARE * range).max(CLIPPED_COUNTS)
}

fn rgb() -> Vec<String> {
    ["R", "G", "B"].map(str::to_owned).to_vec()
}

/// Checks the size of an image before memory is allocated for it.
fn check_size(path: &Path, width: usize, height: usize, length: usize) -> Result<()> {
    Limits::PLATE.check_size(path, "width, height", width, height)?;
    let bytes = width as u128 * height as u128 * 12;
    Limits::PLATE.check_bytes(path, "width, height", bytes, length as u64)
}
