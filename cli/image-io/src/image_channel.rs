//! Single channels of image files: depth passes and mattes.

use std::path::{Path, PathBuf};

use seidel_optics::lens::AperturePicture;

use crate::error::{FileError, Result};
use crate::format::Format;
use crate::formats::exr::{DepthOwner, ExrImage};
use crate::image_file::ImageFile;
use crate::input::Limits;
use crate::raster::RasterImage;
use crate::samples::SampleFormat;
use crate::windows::{FittedSamples, ImageWindows, fit_to_plate};

/// A channel of a file as named on the command line: `FILE` or `FILE:CHANNEL`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelSpec {
    /// The file; may hold a frame pattern.
    pub file: PathBuf,
    /// The channel, if one is named.
    pub channel: Option<String>,
}

impl ChannelSpec {
    /// Splits off the channel, which may be `PART:CHANNEL`: at the first colon after an existing file or after the extension of
    /// an image format, else at the last colon, unless that colon belongs to a drive letter or a folder. The name of an existing
    /// file is not split.
    pub fn parse(text: &str) -> Self {
        let whole = Self {
            file: text.into(),
            channel: None,
        };
        if Path::new(text).is_file() {
            return whole;
        }
        let colons = || text.match_indices(':').map(|(at, _)| at);
        let is_image = |at: &usize| Format::from_path(Path::new(&text[..*at])).is_some();
        let at = (colons().find(|&at| Path::new(&text[..at]).is_file()))
            .or_else(|| colons().find(is_image))
            .or_else(|| text.rfind(':').filter(|&at| !is_of_path(text, at)));
        match at.map(|at| (&text[..at], &text[at + 1..])) {
            Some((file, channel)) if !file.is_empty() && !channel.is_empty() => Self {
                file: file.into(),
                channel: Some(channel.to_owned()),
            },
            _ => whole,
        }
    }
}

/// Returns whether the colon at `at` belongs to a drive letter or the name of a folder.
fn is_of_path(text: &str, at: usize) -> bool {
    let (before, after) = (&text[..at], &text[at + 1..]);
    let is_letter = before.len() == 1 && before.starts_with(|c: char| c.is_ascii_alphabetic());
    let is_drive = is_letter && Format::from_path(Path::new(after)).is_some();
    is_drive || after.contains(['/', '\\'])
}

/// The samples of one channel of an image file, as they are stored.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageChannel {
    /// The path of the file.
    pub file: PathBuf,
    /// The name of the channel.
    pub channel: String,
    /// The windows of the channel; at (0, 0) in all formats but EXR.
    pub windows: ImageWindows,
    /// One sample per pixel, row-major. Integers are scaled to 0..1.
    pub samples: Vec<f32>,
}

impl ImageChannel {
    /// Reads a depth pass, whatever its convention: any channel of an EXR file, or a grey or named channel of a
    /// 12-bit, 16-bit or float file of another format.
    ///
    /// Without `channel` it is the channel of an EXR file whose name is that of depth, or its only channel. Among channels of
    /// several views it is that of `owner`.
    ///
    /// # Errors
    /// A file that cannot be read, no such channel, and 8- and 10-bit files, which are too coarse for depth.
    pub fn read_depth(file: &Path, channel: Option<&str>, owner: DepthOwner) -> Result<Self> {
        match ImageFile::open(file, Limits::PLATE)? {
            // The only channel of a file is depth whatever its name. In a plate it would be colour.
            ImageFile::Exr(image) => match (channel, image.channels().as_slice()) {
                (None, [only]) => Self::depth_of_exr(&image, Some(&only.name), owner),
                _ => Self::depth_of_exr(&image, channel, owner),
            },
            ImageFile::Raster(image) => Self::depth_of_raster(&image, channel),
        }
    }

    /// Returns the depth channel of an EXR file in memory.
    ///
    /// # Errors
    /// No such channel.
    pub fn depth_of_exr(
        image: &ExrImage,
        channel: Option<&str>,
        owner: DepthOwner,
    ) -> Result<Self> {
        let id = image.depth_channel(channel, owner)?;
        Ok(Self {
            file: image.path().to_path_buf(),
            channel: image.full_name_of(id),
            windows: image.windows(id),
            samples: image.samples(id),
        })
    }

    fn depth_of_raster(image: &RasterImage, channel: Option<&str>) -> Result<Self> {
        let format = image.sample_format();
        if matches!(format, SampleFormat::U8 | SampleFormat::U10) {
            return Err(FileError::new(
                image.path(),
                "depth",
                format!("has {format} samples, which are too coarse for depth"),
                "give an EXR, or a 16-bit or float file",
            ));
        }
        let name = channel.unwrap_or(&image.names()[0]);
        // Some programs store grey as equal R, G and B.
        let [red, green, blue] = ["R", "G", "B"].map(|name| image.plane(name));
        let is_grey = red.is_none() || (red == green && green == blue);
        let samples = image.plane(name).filter(|_| channel.is_some() || is_grey);
        let Some(samples) = samples else {
            let problem = match channel {
                Some(name) => format!("has no channel `{name}`"),
                None => "is in colour".to_owned(),
            };
            return Err(unknown_channel(
                image.path(),
                "depth",
                problem,
                image.names(),
            ));
        };
        Ok(Self {
            file: image.path().to_path_buf(),
            channel: name.to_owned(),
            windows: ImageWindows::of_size(image.width(), image.height()),
            samples: samples.to_vec(),
        })
    }

    /// Reads a matte, whose samples are 0 to 1: the channel named, or else `A`, or else the only channel.
    ///
    /// # Errors
    /// A file that cannot be read, and no such channel.
    pub fn read_matte(file: &Path, channel: Option<&str>) -> Result<Self> {
        let image = ImageFile::open(file, Limits::PLATE)?;
        let names = image.channel_names();
        let named = image.place_of_channel(channel.unwrap_or("A"));
        let only = (channel.is_none() && names.len() == 1).then_some(0);
        let Some(index) = named.or(only) else {
            let problem = match channel {
                Some(name) => format!("has no channel `{name}`"),
                None => "has no alpha channel".to_owned(),
            };
            return Err(unknown_channel(file, "matte", problem, &names));
        };
        let (windows, samples) = image.channel(index);
        Ok(Self {
            file: file.to_owned(),
            channel: names[index].clone(),
            windows,
            samples,
        })
    }

    /// Reads a picture of transmission: the mean of R, G and B or the only colour, times A, as the file stores them. White is 1.
    ///
    /// # Errors
    /// A file that cannot be read, or without a colour and alpha.
    pub fn read_transmission(file: &Path) -> Result<Self> {
        let image = ImageFile::open(file, Limits::PLATE)?;
        let names = image.channel_names();
        let place = |name: &str| names.iter().position(|own| own == name);
        let mut colours: Vec<usize> = ["R", "G", "B"].into_iter().filter_map(place).collect();
        if colours.is_empty() {
            colours.extend(place("Y").or((names.len() == 1).then_some(0)));
        }
        let alpha = place("A").filter(|index| !colours.contains(index));
        if colours.is_empty() && alpha.is_none() {
            let problem = "has no channel R, G, B, Y or A".to_owned();
            return Err(unknown_channel(file, "transmission", problem, &names));
        }
        let first = colours.first().or(alpha.as_ref()).copied().unwrap_or(0);
        let (windows, _) = image.channel(first);
        let samples_of = |index: usize| image.channel(index).1;
        let colours: Vec<_> = colours.into_iter().map(samples_of).collect();
        let colours: Vec<&[f32]> = colours.iter().map(Vec::as_slice).collect();
        let alpha = alpha.map(samples_of);
        let pixels = windows.data.width * windows.data.height;
        Ok(Self {
            file: file.to_owned(),
            channel: "transmission".to_owned(),
            windows,
            samples: AperturePicture::transmission(pixels, &colours, alpha.as_deref()),
        })
    }

    /// Fits the channel to the data window of a plate. If both have one display window it is cropped to the plate, or extended by
    /// its edge pixels, with a warning. If not, it must have the plate's size and is taken as it is.
    ///
    /// # Errors
    /// A channel of another size that does not belong to the plate's frame or lies beside the plate.
    pub fn fit_to(&self, plate: ImageWindows) -> Result<FittedSamples> {
        fit_to_plate(
            &self.samples,
            self.windows,
            plate,
            &self.file,
            &self.channel,
        )
    }
}

impl ImageFile {
    /// Returns the full names of all channels, without parts.
    pub(crate) fn channel_names(&self) -> Vec<String> {
        match self {
            Self::Exr(image) => image.channels().into_iter().map(|c| c.name).collect(),
            Self::Raster(image) => image.names().to_vec(),
        }
    }

    /// Returns the place in [`ImageFile::channel_names`] of the channel `name`, which may begin with its part and a colon.
    fn place_of_channel(&self, name: &str) -> Option<usize> {
        let names = self.channel_names();
        let plain = || names.iter().position(|own| own == name);
        let Self::Exr(image) = self else {
            return plain();
        };
        let channels = image.channels();
        let with_part = (channels.into_iter()).position(|own| image.full_name(own) == name);
        with_part.or_else(plain)
    }

    /// Returns the windows and samples of the channel at `index` of [`ImageFile::channel_names`].
    pub(crate) fn channel(&self, index: usize) -> (ImageWindows, Vec<f32>) {
        match self {
            Self::Exr(image) => {
                let id = image.channels()[index].id;
                (image.windows(id), image.samples(id))
            }
            Self::Raster(image) => {
                let windows = ImageWindows::of_size(image.width(), image.height());
                (windows, image.planes[index].clone())
            }
        }
    }
}

fn unknown_channel(file: &Path, field: &str, problem: String, names: &[String]) -> FileError {
    FileError::new(
        file,
        field,
        problem,
        format!(
            "name one of its channels after a colon: {}",
            names.join(", ")
        ),
    )
}
