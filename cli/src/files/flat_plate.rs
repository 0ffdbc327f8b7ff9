//! PNG and TIFF plates: planes of floats in memory, the file's own sample type on disk.

use std::fmt;
use std::path::{Path, PathBuf};

use super::error::{FileError, Result};
use super::limits::Limits;
use super::provenance::Texts;
use super::{png_file, tiff_file};

/// How one sample is stored in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleDepth {
    /// 8-bit unsigned integer; 255 is 1.0.
    U8,
    /// 16-bit unsigned integer; 65535 is 1.0.
    U16,
    /// 16-bit float. Read only: written as [`SampleDepth::F32`].
    F16,
    /// 32-bit float.
    F32,
}

impl SampleDepth {
    /// Whether the format holds whole numbers from 0 to 1 only.
    pub fn is_integer(self) -> bool {
        matches!(self, Self::U8 | Self::U16)
    }
}

impl fmt::Display for SampleDepth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::U8 => "8-bit",
            Self::U16 => "16-bit",
            Self::F16 => "half float",
            Self::F32 => "float",
        })
    }
}

/// What the numbers of a PNG or TIFF file mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Proportional to light.
    Linear,
    /// The sRGB transfer function (IEC 61966-2-1), its two pieces extended beyond 0 and 1.
    Srgb,
}

impl Encoding {
    /// Scene-linear value of a code value, 0 to 1 for the range of the format.
    pub fn decode(self, code: f32) -> f32 {
        match self {
            Self::Linear => code,
            Self::Srgb if code <= 0.040_45 => code / 12.92,
            Self::Srgb => ((f64::from(code) + 0.055) / 1.055).powf(2.4) as f32,
        }
    }

    /// Code value of a scene-linear value; the inverse of [`Encoding::decode`].
    pub fn encode(self, linear: f32) -> f32 {
        match self {
            Self::Linear => linear,
            Self::Srgb if linear <= 0.003_130_8 => linear * 12.92,
            Self::Srgb => (1.055 * f64::from(linear).powf(1.0 / 2.4) - 0.055) as f32,
        }
    }
}

/// The format of a [`FlatPlate`].
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Container {
    /// PNG with its colour profile.
    Png { icc: Option<Vec<u8>> },
    /// TIFF with the tags that are carried over and the meaning of its alpha.
    Tiff(tiff_file::Carried),
}

/// A PNG or TIFF picture. Samples are code values: integers scaled to 0..1, floats as they are.
#[derive(Debug, Clone)]
pub struct FlatPlate {
    pub(super) path: PathBuf,
    pub(super) container: Container,
    pub(super) depth: SampleDepth,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) names: Vec<String>,
    pub(super) planes: Vec<Vec<f32>>,
    /// Texts that the file holds, each with its name.
    pub(super) texts: Texts,
}

impl FlatPlate {
    /// Reads a PNG (8 or 16 bit) or TIFF (8 or 16 bit, half or float) file, told apart by content.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, or of another kind.
    pub fn open(path: &Path) -> Result<Self> {
        Self::open_within(path, Limits::PLATE)
    }

    pub(super) fn open_within(path: &Path, limits: Limits) -> Result<Self> {
        match super::format::detect(path)? {
            super::format::Format::Png => png_file::read(path, limits),
            super::format::Format::Tiff => tiff_file::read(path, limits),
            super::format::Format::Exr => Err(FileError::new(
                path,
                "",
                "is an OpenEXR file",
                "give a PNG or TIFF file here",
            )),
        }
    }

    /// The file it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Width, pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Texts that the file holds beside the picture, each with its name.
    pub fn texts(&self) -> &[(String, String)] {
        &self.texts
    }

    /// How samples are stored.
    pub fn depth(&self) -> SampleDepth {
        self.depth
    }

    /// Channel names, in the order of the planes: `Y` or `R`, `G`, `B`, and `A` last where there is alpha.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The code values of the channel called `name`, row-major.
    pub fn plane(&self, name: &str) -> Option<&[f32]> {
        let index = self.names.iter().position(|n| n == name)?;
        Some(&self.planes[index])
    }

    /// Puts other code values in place of a channel's.
    ///
    /// # Errors
    /// A channel that the file has not, and a sample count that does not fill it.
    pub fn replace(&mut self, name: &str, samples: Vec<f32>) -> Result<()> {
        let index = self.names.iter().position(|n| n == name);
        let (Some(index), true) = (index, samples.len() == self.width * self.height) else {
            return Err(FileError::new(
                &self.path,
                format!("channel {name}"),
                format!("cannot take {} samples", samples.len()),
                format!(
                    "give {} x {} samples for one of {}",
                    self.width,
                    self.height,
                    self.names.join(", ")
                ),
            ));
        };
        self.planes[index] = samples;
        Ok(())
    }

    /// Rounds the code values to what the file will hold.
    pub(super) fn round(&mut self) {
        let stored: fn(f32) -> f32 = match self.depth {
            SampleDepth::U8 => |code| f32::from(to_u8(code)) / 255.0,
            SampleDepth::U16 => |code| f32::from(to_u16(code)) / 65535.0,
            SampleDepth::F16 | SampleDepth::F32 => return,
        };
        for code in self.planes.iter_mut().flatten() {
            *code = stored(*code);
        }
    }

    /// Writes the picture whole or not at all, in the format and sample type it was read in (half
    /// float as float). Returns a sentence for each thing that the format could not hold.
    ///
    /// # Errors
    /// A target that cannot be written.
    pub fn write(&self, path: &Path) -> Result<Vec<String>> {
        match &self.container {
            Container::Png { icc } => png_file::write(path, self, icc.as_deref())?,
            Container::Tiff(carried) => tiff_file::write(path, self, carried)?,
        }
        Ok(self.unheld())
    }

    fn unheld(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if matches!(&self.container, Container::Tiff(carried) if carried.more_pages) {
            notes.push("only the first page of the TIFF is kept".to_owned());
        }
        if self.depth == SampleDepth::F16 {
            notes.push("half float TIFF is written as 32-bit float".to_owned());
        }
        if !self.depth.is_integer() {
            return notes;
        }
        for (name, plane) in self.names.iter().zip(&self.planes) {
            let count = |is: fn(&f32) -> bool| plane.iter().filter(|v| is(v)).count();
            for (what, count) in [
                ("below 0", count(|v| *v < 0.0)),
                ("over 1", count(|v| *v > 1.0)),
                ("not a number", count(|v| v.is_nan())),
            ] {
                if count > 0 {
                    notes.push(format!(
                        "channel {name}: {count} samples {what} do not fit {} integers and are clipped; write EXR or float TIFF to keep them",
                        self.depth
                    ));
                }
            }
        }
        notes
    }

    /// The planes interleaved into integers of full range `max`, clipped; NaN becomes 0.
    pub(super) fn interleaved<T>(&self, convert: impl Fn(f32) -> T) -> Vec<T> {
        let mut samples = Vec::with_capacity(self.width * self.height * self.planes.len());
        for index in 0..self.width * self.height {
            for plane in &self.planes {
                samples.push(convert(plane[index]));
            }
        }
        samples
    }

    /// Takes interleaved samples apart into planes.
    pub(super) fn planes_of<T: Copy>(
        samples: &[T],
        channels: usize,
        convert: impl Fn(T) -> f32,
    ) -> Vec<Vec<f32>> {
        (0..channels)
            .map(|channel| {
                let own = samples.iter().skip(channel).step_by(channels);
                own.map(|&s| convert(s)).collect()
            })
            .collect()
    }
}

/// A code value as an 8-bit integer: rounded, clipped, NaN as 0.
pub(super) fn to_u8(code: f32) -> u8 {
    (code * 255.0).round() as u8
}

/// A code value as a 16-bit integer: rounded, clipped, NaN as 0.
pub(super) fn to_u16(code: f32) -> u16 {
    (code * 65535.0).round() as u16
}

/// Channel names of a picture with or without colour and alpha.
pub(super) fn names(colour: bool, alpha: bool) -> Vec<String> {
    let names: &[&str] = match (colour, alpha) {
        (false, false) => &["Y"],
        (false, true) => &["Y", "A"],
        (true, false) => &["R", "G", "B"],
        (true, true) => &["R", "G", "B", "A"],
    };
    names.iter().map(|&n| n.to_owned()).collect()
}
