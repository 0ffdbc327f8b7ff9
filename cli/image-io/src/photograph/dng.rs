//! DNG (Adobe Digital Negative 1.6): raw mosaics and linear raw images, uncompressed or with lossless JPEG.

use std::path::Path;

use rayon::prelude::*;
use seidel_optics::mosaic::Mosaic;

use super::directory::{Directory, TiffBytes};
use super::{
    ColourFilter, PhotographFile, PhotographOptions, Precision, check_size, clipping_level,
    lossless_jpeg, rgb,
};
use crate::error::{FileError, Result};

const SUBFILE_TYPE: u16 = 254;
const WIDTH: u16 = 256;
const HEIGHT: u16 = 257;
const BITS: u16 = 258;
const COMPRESSION: u16 = 259;
const PHOTOMETRIC: u16 = 262;
const STRIP_OFFSETS: u16 = 273;
const SAMPLES_PER_PIXEL: u16 = 277;
const ROWS_PER_STRIP: u16 = 278;
const STRIP_LENGTHS: u16 = 279;
const PLANAR: u16 = 284;
const TILE_WIDTH: u16 = 322;
const TILE_HEIGHT: u16 = 323;
const TILE_OFFSETS: u16 = 324;
const TILE_LENGTHS: u16 = 325;
const SAMPLE_FORMAT: u16 = 339;
const CFA_SIZE: u16 = 33421;
const CFA_PATTERN: u16 = 33422;
const DNG_VERSION: u16 = 50706;
const CFA_LAYOUT: u16 = 50711;
const LINEARISATION: u16 = 50712;
const BLACK_SIZE: u16 = 50713;
const BLACK: u16 = 50714;
const BLACK_BY_COLUMN: u16 = 50715;
const BLACK_BY_ROW: u16 = 50716;
const WHITE: u16 = 50717;
const ACTIVE_AREA: u16 = 50829;
const NOISE_PROFILE: u16 = 51041;

const PHOTOMETRIC_CFA: usize = 32803;
const PHOTOMETRIC_LINEAR: usize = 34892;

/// Reads a DNG file; `None` for another TIFF file.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    options: &PhotographOptions,
) -> Result<Option<PhotographFile>> {
    let file = TiffBytes::new(path, bytes);
    let directories = file.directories()?;
    let is_dng = directories
        .iter()
        .any(|d| !d.values(DNG_VERSION).is_empty());
    let raw = directories
        .iter()
        .filter(|d| {
            let photometric = d.whole(PHOTOMETRIC, 0);
            photometric == PHOTOMETRIC_CFA || (is_dng && photometric == PHOTOMETRIC_LINEAR)
        })
        .max_by_key(|d| {
            // Enhanced images, previews and masks have other types than the primary image.
            let is_primary = d.whole(SUBFILE_TYPE, 0) == 0;
            let pixels = d.whole(WIDTH, 0).saturating_mul(d.whole(HEIGHT, 0));
            (is_primary, pixels)
        });
    let Some(raw) = raw else {
        if !is_dng {
            return Ok(None);
        }
        return Err(FileError::new(
            path,
            "PhotometricInterpretation",
            "is of no raw image",
            "export the DNG with its raw data, not as a preview",
        ));
    };
    let image = RawImage {
        file: &file,
        raw,
        width: raw.whole(WIDTH, 0),
        height: raw.whole(HEIGHT, 0),
        channels: raw.whole(SAMPLES_PER_PIXEL, 1),
        bits: raw.whole(BITS, 16),
    };
    let noise = (raw.values(NOISE_PROFILE).first()).or_else(|| {
        directories
            .iter()
            .find_map(|d| d.values(NOISE_PROFILE).first())
    });
    image.read(options, noise.copied()).map(Some)
}

/// The directory of the raw image.
struct RawImage<'a> {
    file: &'a TiffBytes<'a>,
    raw: &'a Directory,
    width: usize,
    height: usize,
    channels: usize,
    bits: usize,
}

/// A rectangle of the file's image, in pixels.
#[derive(Clone, Copy)]
struct Area {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl RawImage<'_> {
    fn refuse(&self, field: &str, problem: String, remedy: &str) -> FileError {
        FileError::new(self.file.path, field, problem, remedy)
    }

    fn read(&self, options: &PhotographOptions, noise: Option<f64>) -> Result<PhotographFile> {
        const CONVERT: &str = "convert it again: `dnglab convert IN OUT.dng`";
        let path = self.file.path;
        if self.channels == 0 || self.channels > 4 {
            let problem = format!("is {}", self.channels);
            return Err(self.refuse("SamplesPerPixel", problem, CONVERT));
        }
        if !(8..=16).contains(&self.bits) || self.raw.whole(SAMPLE_FORMAT, 1) != 1 {
            let problem = format!("is {}, or the samples are not integers", self.bits);
            return Err(self.refuse("BitsPerSample", problem, CONVERT));
        }
        if self.channels > 1 && self.raw.whole(PLANAR, 1) != 1 {
            let problem = "is separate planes".to_owned();
            return Err(self.refuse("PlanarConfiguration", problem, CONVERT));
        }
        let length = self.file.bytes.len();
        check_size(path, self.width, self.height * self.channels, length)?;
        let mosaic = self.mosaic(options)?;
        let samples = self.samples()?;
        let area = self.active_area()?;
        let levels = Levels::of(self, area, options);
        let table = self.raw.values(LINEARISATION);
        let clipped = levels.clipped();
        let plane = |channel: usize| -> Vec<f32> {
            let mut plane = Vec::with_capacity(area.width * area.height);
            for y in 0..area.height {
                for x in 0..area.width {
                    let pixel = (y + area.top) * self.width + x + area.left;
                    let stored = samples[pixel * self.channels + channel];
                    let linear = match table {
                        [] => f64::from(stored),
                        // Values beyond the table stand for its last entry.
                        table => table[usize::from(stored).min(table.len() - 1)],
                    };
                    let black = levels.black_at(x, y, channel);
                    let value = (linear - black) as f32;
                    // Each channel clips at its own level; above it, all are at the common one.
                    let is_clipped =
                        value >= clipping_level(black as f32, levels.white_of(channel) as f32);
                    plane.push(if is_clipped {
                        value.max(clipped)
                    } else {
                        value
                    });
                }
            }
            plane
        };
        let channels = match (mosaic, self.channels) {
            (Some(_), _) => rgb(),
            (None, 3) => rgb(),
            (None, 1) => vec!["Y".to_owned()],
            (None, count) => {
                let problem = format!("is {count} for a linear image");
                return Err(self.refuse("SamplesPerPixel", problem, CONVERT));
            }
        };
        let range = levels.white_of(0) - levels.mean_black();
        let lowest = levels.white.iter().copied().fold(f64::INFINITY, f64::min);
        if lowest <= levels.mean_black() {
            let problem = format!("is {lowest}, not above the black level");
            return Err(self.refuse("WhiteLevel", problem, "give --black and --white"));
        }
        Ok(PhotographFile {
            width: area.width,
            height: area.height,
            planes: (0..self.channels).map(plane).collect(),
            channels,
            mosaic,
            white: clipped,
            // The profile states the variance per unit of a signal that is 1 at the white level.
            gain: noise
                .filter(|s| *s > 0.0 && s.is_finite())
                .map(|s| s * range),
            code_scale: None,
            precision: Precision::Linear,
            warnings: levels.warnings,
        })
    }

    /// Returns the mosaic; `None` for a linear image.
    fn mosaic(&self, options: &PhotographOptions) -> Result<Option<Mosaic>> {
        if self.raw.whole(PHOTOMETRIC, 0) == PHOTOMETRIC_LINEAR {
            return Ok(None);
        }
        match options.cfa {
            Some(ColourFilter::Mosaic(mosaic)) => return Ok(Some(mosaic)),
            Some(ColourFilter::None) => return Ok(None),
            None => {}
        }
        let size = self.raw.values(CFA_SIZE);
        let layout = self.raw.whole(CFA_LAYOUT, 1);
        let letters: String = (self.raw.values(CFA_PATTERN).iter())
            .map(|v| match *v as u32 {
                0 => 'R',
                1 => 'G',
                2 => 'B',
                _ => '?',
            })
            .collect();
        let mosaic = Mosaic::parse(&letters).ok();
        match mosaic.filter(|_| size == [2.0, 2.0] && layout == 1) {
            Some(mosaic) => Ok(Some(mosaic)),
            None => Err(self.refuse(
                "CFAPattern",
                format!("is {letters} of {size:?} pixels, which is not a block of 2 x 2 colours"),
                "use a camera with a Bayer mosaic, or develop the photograph linearly and give it as TIFF or OpenEXR",
            )),
        }
    }

    /// Returns the part of the image that is exposed to light.
    fn active_area(&self) -> Result<Area> {
        let whole = Area {
            left: 0,
            top: 0,
            width: self.width,
            height: self.height,
        };
        let [top, left, bottom, right] = *self.raw.values(ACTIVE_AREA) else {
            return Ok(whole);
        };
        let (left, top) = (left as usize, top as usize);
        let (right, bottom) = (right as usize, bottom as usize);
        if left >= right || top >= bottom || right > self.width || bottom > self.height {
            let problem = "lies outside the image".to_owned();
            return Err(self.refuse("ActiveArea", problem, "copy the file again"));
        }
        Ok(Area {
            left,
            top,
            width: right - left,
            height: bottom - top,
        })
    }

    /// Returns all samples as stored, pixel by pixel.
    fn samples(&self) -> Result<Vec<u16>> {
        let row = self.width * self.channels;
        let mut image = vec![0_u16; row * self.height];
        let is_tiled = !self.raw.values(TILE_OFFSETS).is_empty();
        let (offsets, lengths, size) = if is_tiled {
            let size = (
                self.raw.whole(TILE_WIDTH, 0),
                self.raw.whole(TILE_HEIGHT, 0),
            );
            (TILE_OFFSETS, TILE_LENGTHS, size)
        } else {
            let rows = self.raw.whole(ROWS_PER_STRIP, self.height).min(self.height);
            (STRIP_OFFSETS, STRIP_LENGTHS, (self.width, rows))
        };
        let (width, height) = size;
        let (offsets, lengths) = (self.raw.values(offsets), self.raw.values(lengths));
        if width == 0 || height == 0 || offsets.is_empty() {
            return Err(self.file.damaged("its raw image has no data"));
        }
        let pixels = self.width.max(64) * self.height.max(64) * 4;
        if width.checked_mul(height).is_none_or(|p| p > pixels) {
            return Err(self.file.damaged("its tiles are larger than the image"));
        }
        let across = self.width.div_ceil(width);
        let down = self.height.div_ceil(height);
        if offsets.len() < across * down || lengths.len() != offsets.len() {
            return Err(self.file.damaged("tiles of its raw image are missing"));
        }
        let tiles: Vec<Vec<u16>> = (0..across * down)
            .into_par_iter()
            .map(|k| {
                let data = self.file.slice(offsets[k] as usize, lengths[k] as usize)?;
                let rows = if is_tiled {
                    height
                } else {
                    height.min(self.height - k / across * height)
                };
                self.tile(data, width, rows)
            })
            .collect::<Result<_>>()?;
        for (k, tile) in tiles.iter().enumerate() {
            let (left, top) = (k % across * width, k / across * height);
            let columns = width.min(self.width - left) * self.channels;
            for y in 0..height.min(self.height - top) {
                let from = &tile[y * width * self.channels..][..columns];
                let start = (top + y) * row + left * self.channels;
                image[start..start + columns].copy_from_slice(from);
            }
        }
        Ok(image)
    }

    /// Decodes one strip or tile of `width` x `height` pixels.
    fn tile(&self, data: &[u8], width: usize, height: usize) -> Result<Vec<u16>> {
        let row = width * self.channels;
        let count = row * height;
        match self.raw.whole(COMPRESSION, 1) {
            1 => unpacked(data, row, height, self.bits, self.file.big_endian)
                .ok_or_else(|| self.file.damaged("samples are missing")),
            7 => {
                let decoded = lossless_jpeg::decode(data, count)
                    .map_err(|problem| self.file.damaged(&problem))?;
                if decoded.samples.len() != count {
                    return Err(self.file.damaged("a tile has too few samples"));
                }
                Ok(decoded.samples)
            }
            other => Err(self.refuse(
                "Compression",
                format!("is {other}, which is not supported"),
                "convert it without loss: `dnglab convert IN OUT.dng`",
            )),
        }
    }
}

/// Unpacks rows of samples of 8 to 16 bits: whole bytes in the file's order, others packed from the highest bit.
fn unpacked(
    data: &[u8],
    row: usize,
    rows: usize,
    bits: usize,
    big_endian: bool,
) -> Option<Vec<u16>> {
    let row_bytes = (row * bits).div_ceil(8);
    let data = data.get(..row_bytes * rows)?;
    let mut samples = Vec::with_capacity(row * rows);
    for row_data in data.chunks_exact(row_bytes.max(1)) {
        match bits {
            8 => samples.extend(row_data.iter().map(|b| u16::from(*b))),
            16 => samples.extend(row_data.chunks_exact(2).map(|pair| {
                let pair = [pair[0], pair[1]];
                if big_endian {
                    u16::from_be_bytes(pair)
                } else {
                    u16::from_le_bytes(pair)
                }
            })),
            _ => {
                let (mut buffer, mut count) = (0_u32, 0);
                let before = samples.len();
                for byte in row_data {
                    buffer = buffer << 8 | u32::from(*byte);
                    count += 8;
                    if count >= bits && samples.len() - before < row {
                        count -= bits;
                        samples.push((buffer >> count) as u16 & ((1 << bits) - 1));
                    }
                }
            }
        }
    }
    Some(samples)
}

/// Black and white levels.
struct Levels {
    /// Black of the repeating block: rows, then columns, then channels.
    block: Vec<f64>,
    block_size: (usize, usize),
    channels: usize,
    by_column: Vec<f64>,
    by_row: Vec<f64>,
    /// Of each channel, or one of all.
    white: Vec<f64>,
    warnings: Vec<String>,
}

impl Levels {
    fn of(image: &RawImage, area: Area, options: &PhotographOptions) -> Self {
        let raw = image.raw;
        let mut warnings = Vec::new();
        let channels = image.channels;
        let size = match *raw.values(BLACK_SIZE) {
            [rows, columns] => (rows as usize, columns as usize),
            _ => (1, 1),
        };
        let stated = raw.values(BLACK);
        let wanted = size.0 * size.1 * channels;
        let mut levels = Self {
            block: vec![0.0],
            block_size: (1, 1),
            channels: 1,
            by_column: Vec::new(),
            by_row: Vec::new(),
            white: match (options.white, raw.values(WHITE)) {
                (Some(white), _) => vec![f64::from(white)],
                (None, []) => vec![(1_u32 << image.bits) as f64 - 1.0],
                (None, stated) => stated.to_vec(),
            },
            warnings: Vec::new(),
        };
        if let Some(black) = options.black {
            levels.block = vec![f64::from(black)];
        } else if stated.len() == wanted && wanted > 0 {
            levels.block = stated.to_vec();
            (levels.block_size, levels.channels) = (size, channels);
        } else if let [black, others @ ..] = stated {
            levels.block = vec![*black];
            if others.iter().any(|other| other != black) {
                warnings.push(format!(
                    "{}: BlackLevel has {} values where {wanted} are wanted, and {black} is used for all pixels; give --black if it is another",
                    image.file.path.display(),
                    stated.len()
                ));
            }
        } else if raw.values(BLACK_BY_COLUMN).is_empty() && raw.values(BLACK_BY_ROW).is_empty() {
            warnings.push(format!(
                "{}: states no BlackLevel, which is taken as 0; give --black if it is not",
                image.file.path.display()
            ));
        }
        if options.black.is_none() {
            let by_place = [
                (BLACK_BY_COLUMN, area.width, &mut levels.by_column),
                (BLACK_BY_ROW, area.height, &mut levels.by_row),
            ];
            for (tag, count, deltas) in by_place {
                let stated = raw.values(tag);
                if stated.len() == count {
                    *deltas = stated.to_vec();
                } else if !stated.is_empty() {
                    warnings.push(format!(
                        "{}: {} differences of the black level for {count} rows or columns are left out",
                        image.file.path.display(),
                        stated.len()
                    ));
                }
            }
        }
        levels.warnings = warnings;
        levels
    }

    fn white_of(&self, channel: usize) -> f64 {
        self.white[channel.min(self.white.len() - 1)]
    }

    /// Returns the counts above black from which on a pixel of any channel counts as clipped.
    fn clipped(&self) -> f32 {
        let white = self.white.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        clipping_level(self.mean_black() as f32, white as f32)
    }

    fn black_at(&self, x: usize, y: usize, channel: usize) -> f64 {
        let (rows, columns) = self.block_size;
        let channel = channel.min(self.channels - 1);
        let of_block = self.block[(y % rows * columns + x % columns) * self.channels + channel];
        let delta = |all: &[f64], k: usize| all.get(k).copied().unwrap_or(0.0);
        of_block + delta(&self.by_column, x) + delta(&self.by_row, y)
    }

    fn mean_black(&self) -> f64 {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        mean(&self.block) + mean(&self.by_column) + mean(&self.by_row)
    }
}
