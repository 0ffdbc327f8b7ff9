//! Depth passes: raw numbers by pixel, whatever they mean.

use std::path::{Path, PathBuf};

use crate::error::{FileError, Result};
use crate::exr::plate::ExrPlate;
use crate::flat_plate::{FlatPlate, SampleDepth};
use crate::format::{Format, detect};
use crate::windows::{Windows, fitted};

/// A depth pass as named on the command line: `FILE` or `FILE:CHANNEL`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DepthSpec {
    /// The file; may hold a frame pattern.
    pub file: String,
    /// The channel, where one was named.
    pub channel: Option<String>,
}

impl DepthSpec {
    /// Splits off the channel at the last colon, unless that colon belongs to a drive letter or a
    /// folder, or the whole is the name of an existing file.
    pub fn parse(text: &str) -> Self {
        let whole = Self {
            file: text.to_owned(),
            channel: None,
        };
        let Some((file, channel)) = text.rsplit_once(':') else {
            return whole;
        };
        let is_drive = file.len() == 1
            && file.starts_with(|c: char| c.is_ascii_alphabetic())
            && (channel.starts_with(['/', '\\']) || Format::of_name(Path::new(channel)).is_some());
        let in_folder = channel.contains(['/', '\\']);
        if file.is_empty()
            || channel.is_empty()
            || is_drive
            || in_folder
            || Path::new(text).is_file()
        {
            return whole;
        }
        Self {
            file: file.to_owned(),
            channel: Some(channel.to_owned()),
        }
    }
}

/// The numbers of a depth pass, as they stand in the file: metres, inverse or anything else.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthPass {
    /// The file it is from.
    pub file: PathBuf,
    /// Name of the channel it is from.
    pub channel: String,
    /// Where the pixels lie; at (0, 0) in all but EXR.
    pub windows: Windows,
    /// One number a pixel, row-major. Integers are scaled to 0..1.
    pub samples: Vec<f32>,
}

impl DepthPass {
    /// Reads a depth pass: any channel of an EXR file (if none is named, the one that looks like
    /// depth), or a grey or named channel of a 12-bit, 16-bit or float file of another format.
    ///
    /// # Errors
    /// A file that cannot be read, no such channel, and 8- and 10-bit files, whose steps would show.
    pub fn open(file: &Path, channel: Option<&str>) -> Result<Self> {
        match detect(file)? {
            Format::Exr => {
                let plate = ExrPlate::open(file)?;
                // A file of its own with one channel is depth whatever that is called; within a plate
                // the same channel would be its colour.
                match (channel, plate.channels().as_slice()) {
                    (None, [only]) => Self::of_plate(&plate, Some(&only.name)),
                    _ => Self::of_plate(&plate, channel),
                }
            }
            _ => Self::of_flat(&FlatPlate::open(file)?, channel),
        }
    }

    /// The depth channel of a plate that is open already.
    ///
    /// # Errors
    /// No such channel.
    pub fn of_plate(plate: &ExrPlate, channel: Option<&str>) -> Result<Self> {
        let id = plate.depth_channel(channel)?;
        Ok(Self {
            file: plate.path().to_path_buf(),
            channel: plate.channel_name(id),
            windows: Windows {
                data: plate.data_window(id),
                display: plate.display_window(),
            },
            samples: plate.samples(id),
        })
    }

    fn of_flat(plate: &FlatPlate, channel: Option<&str>) -> Result<Self> {
        if matches!(plate.depth(), SampleDepth::U8 | SampleDepth::U10) {
            return Err(FileError::new(
                plate.path(),
                "depth",
                format!(
                    "has {} samples, which are too coarse for depth",
                    plate.depth()
                ),
                "give an EXR, or a 16-bit or float file",
            ));
        }
        let name = channel.unwrap_or(&plate.names()[0]);
        // Some writers store one number as equal R, G and B.
        let colours = ["R", "G", "B"].map(|n| plate.plane(n));
        let is_grey =
            colours[0].is_none() || (colours[0] == colours[1] && colours[1] == colours[2]);
        let samples = plate.plane(name).filter(|_| channel.is_some() || is_grey);
        let Some(samples) = samples else {
            return Err(FileError::new(
                plate.path(),
                "depth",
                match channel {
                    Some(name) => format!("has no channel `{name}`"),
                    None => "is in colour".to_owned(),
                },
                format!(
                    "name one of its channels after a colon: {}",
                    plate.names().join(", ")
                ),
            ));
        };
        Ok(Self {
            file: plate.path().to_path_buf(),
            channel: name.to_owned(),
            windows: Windows::of_size(plate.width(), plate.height()),
            samples: samples.to_vec(),
        })
    }

    /// The samples over those of a plate, as [`fitted`] has them; with a remark where there is something to say.
    ///
    /// # Errors
    /// A pass that neither covers the plate nor is of the same picture.
    pub fn over(&self, plate: Windows) -> Result<(Vec<f32>, Option<String>)> {
        let what = format!("channel {}", self.channel);
        fitted(&self.samples, self.windows, plate, (&self.file, &what))
    }
}
