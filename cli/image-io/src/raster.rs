//! Images of formats that store a single image, and the metadata that each format keeps beside the pixels.

use std::fmt;
use std::path::{Path, PathBuf};

use half::f16;

use crate::error::{FileError, Result};
use crate::format::Format;
use crate::input::InputFile;
use crate::metadata::{CommonMetadata, TextAttributes, is_provenance};
use crate::part::Part;
use crate::rgbe;
use crate::samples::{Encoding, MAX_HALF, SampleFormat, clip_to_half, quantise};

/// An image of a format that stores a single one.
///
/// Planes are row-major and hold code values: integers scaled to 0..1, floats as they are.
#[derive(Debug, Clone)]
pub struct RasterImage {
    pub(crate) format: Format,
    pub(crate) path: PathBuf,
    pub(crate) metadata: Box<dyn Metadata>,
    pub(crate) sample_format: SampleFormat,
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) names: Vec<String>,
    pub(crate) planes: Vec<Vec<f32>>,
    /// Text metadata that any program may show, provenance among them.
    pub(crate) texts: TextAttributes,
    /// Whether samples were replaced after reading.
    pub(crate) changed: bool,
    /// Warnings to return when the image is written.
    pub(crate) warnings: Vec<String>,
}

impl RasterImage {
    /// Creates the image of a file with the usual channel names for its number of planes, each of `size` (width,
    /// height), and without texts.
    pub(crate) fn new(
        input: &InputFile,
        metadata: impl Metadata + 'static,
        sample_format: SampleFormat,
        size: (usize, usize),
        planes: Vec<Vec<f32>>,
    ) -> Self {
        Self {
            format: input.format,
            path: input.path.to_path_buf(),
            metadata: Box::new(metadata),
            sample_format,
            width: size.0,
            height: size.1,
            names: channel_names(planes.len()),
            planes,
            texts: TextAttributes::new(),
            changed: false,
            warnings: Vec::new(),
        }
    }

    /// Returns the format of the file.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the width, pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the height, pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns the format in which samples are stored.
    pub fn sample_format(&self) -> SampleFormat {
        self.sample_format
    }

    /// Returns the channel names in the order of the planes: `Y` or `R`, `G`, `B`, and `A` last if there is alpha.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the code values of the channel called `name`, row-major.
    pub fn plane(&self, name: &str) -> Option<&[f32]> {
        let index = self.names.iter().position(|n| n == name)?;
        Some(&self.planes[index])
    }

    /// Replaces the code values of a channel.
    ///
    /// # Errors
    /// An unknown channel, and a sample count that does not fill it.
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
        self.changed = true;
        Ok(())
    }

    /// Quantises the code values to the sample format of the file.
    pub(crate) fn quantise(&mut self) {
        if let Some(full_scale) = self.sample_format.full_scale() {
            let steps = f32::from(full_scale);
            for code in self.planes.iter_mut().flatten() {
                *code = f32::from(quantise(*code, full_scale)) / steps;
            }
        }
        if self.sample_format == SampleFormat::F16 {
            for sample in self.planes.iter_mut().flatten() {
                *sample = f16::from_f32(clip_to_half(*sample)).to_f32();
            }
        }
        if let (SampleFormat::Rgbe, [red, green, blue]) = (self.sample_format, &mut self.planes[..])
        {
            for ((red, green), blue) in red.iter_mut().zip(green).zip(blue) {
                [*red, *green, *blue] = rgbe::quantise_pixel([*red, *green, *blue]);
            }
        }
    }

    /// Returns the encoding of the code values unless the user chooses another: that of the file, else sRGB for
    /// integers and linear for floats.
    pub(crate) fn default_encoding(&self) -> Encoding {
        let by_samples = if self.sample_format.is_integer() {
            Encoding::Srgb
        } else {
            Encoding::Linear
        };
        self.metadata.encoding().unwrap_or(by_samples)
    }

    /// Returns the memory that the samples take, bytes.
    pub(crate) fn memory_bytes(&self) -> u64 {
        (self.planes.len() * self.width * self.height * size_of::<f32>()) as u64
    }

    /// Describes the file.
    pub(crate) fn describe(&self) -> Part {
        let sample_format = self.sample_format.to_string();
        let channel = |name: &String| (name.clone(), sample_format.clone());
        let texts = self.texts.iter().cloned();
        let (provenance, attributes) = texts.partition(|(name, _)| is_provenance(name));
        Part {
            name: None,
            size: (self.width, self.height),
            channels: self.names.iter().map(channel).collect(),
            storage: self.metadata.summary(),
            attributes,
            provenance,
        }
    }

    /// Writes the image in its own format and sample format, whole or not at all. Returns warnings about everything
    /// that the file does not hold.
    ///
    /// # Errors
    /// A target that cannot be written, and JPEG, which is read only.
    pub fn write(&self, path: &Path) -> Result<Vec<String>> {
        self.metadata.write(path, self)?;
        let mut warnings = self.warnings.clone();
        warnings.extend(self.lost_images());
        warnings.extend(self.metadata.rewrite_losses(self));
        for (name, plane) in self.names.iter().zip(&self.planes) {
            warnings.extend(self.clipping_warnings(name, plane));
        }
        Ok(warnings)
    }

    /// Returns a warning if the file has more images than the one that was read.
    pub(crate) fn lost_images(&self) -> Option<String> {
        let image = self.metadata.multiple_images()?;
        Some(format!("only the first {image} is kept"))
    }

    /// Returns a warning for each way in which samples of a plane exceed the sample format.
    fn clipping_warnings(&self, name: &str, plane: &[f32]) -> Vec<String> {
        let is_half = self.sample_format == SampleFormat::F16;
        let (max, above, alternative) = match self.sample_format {
            SampleFormat::F32 => return Vec::new(),
            SampleFormat::F16 => (MAX_HALF, "over 65504", "EXR as float"),
            SampleFormat::Rgbe => (rgbe::MAX_SAMPLE, "over 1.7e38", "EXR"),
            _ => (1.0, "over 1", "EXR or float TIFF"),
        };
        let range = match self.sample_format {
            SampleFormat::Rgbe => "RGBE samples".to_owned(),
            format if is_half => format!("{format} samples"),
            format => format!("{format} integers"),
        };
        let count = |is: &dyn Fn(f32) -> bool| plane.iter().filter(|v| is(**v)).count();
        // Half floats hold negative values, infinities and NaN.
        let counts = [
            ("below 0", count(&|v| v < 0.0 && !is_half)),
            (above, count(&|v| v > max && !(is_half && v.is_infinite()))),
            (
                "below -65504",
                count(&|v| is_half && v < -max && v.is_finite()),
            ),
            ("not a number", count(&|v| v.is_nan() && !is_half)),
        ];
        let clipped = counts.into_iter().filter(|(_, count)| *count > 0);
        clipped
            .map(|(problem, count)| {
                format!(
                    "channel {name}: {count} samples {problem} do not fit {range} and are clipped; write {alternative} to keep them"
                )
            })
            .collect()
    }

    /// Returns the samples of all planes interleaved, each converted by `convert`.
    pub(crate) fn interleaved<T>(&self, convert: impl Fn(f32) -> T) -> Vec<T> {
        let mut samples = Vec::with_capacity(self.width * self.height * self.planes.len());
        for index in 0..self.width * self.height {
            for plane in &self.planes {
                samples.push(convert(plane[index]));
            }
        }
        samples
    }
}

/// The metadata of a format that stores a single image. They pass through unchanged if the image is written in its own
/// format again.
pub(crate) trait Metadata: CloneMetadata + fmt::Debug + Send + Sync {
    /// Writes `image`, which has these metadata, whole or not at all.
    ///
    /// # Errors
    /// A format that is read only, and a file that cannot be written.
    fn write(&self, path: &Path, image: &RasterImage) -> Result<()>;

    /// Returns the encoding that the file states; `None` in formats without such a statement.
    fn encoding(&self) -> Option<Encoding> {
        None
    }

    /// Returns the width of a pixel over its height.
    fn pixel_aspect(&self) -> f64 {
        1.0
    }

    /// Returns whether colour is premultiplied by alpha.
    fn is_premultiplied(&self) -> bool {
        true
    }

    /// Returns the ICC profile.
    fn icc_profile(&self) -> Option<&[u8]> {
        None
    }

    /// Returns the metadata that other formats store too.
    fn common(&self) -> CommonMetadata {
        CommonMetadata::default()
    }

    /// Removes every field about the colour space of the samples. Returns the names of the removed fields.
    fn remove_colour_space(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Returns what is worth showing to the user, by name.
    fn summary(&self) -> TextAttributes {
        TextAttributes::new()
    }

    /// Returns a warning about how the samples are interpreted.
    fn read_warning(&self, _encoding: AssumedEncoding) -> Option<String> {
        None
    }

    /// Returns warnings about metadata that are lost when `image` is written in the same format.
    fn rewrite_losses(&self, _image: &RasterImage) -> Vec<String> {
        Vec::new()
    }

    /// Returns the name of the metadata that are lost in another format, which stores the common metadata called
    /// `kept`.
    fn conversion_loss(&self, _kept: &[&str]) -> Option<String> {
        None
    }

    /// Returns the name of one image, such as "page of the TIFF", if the file has more than the one that is read.
    fn multiple_images(&self) -> Option<&'static str> {
        None
    }
}

/// The encoding with which samples are read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AssumedEncoding {
    /// `None` if a colour space takes its place.
    pub(crate) encoding: Option<Encoding>,
    /// Whether the user has chosen it.
    pub(crate) from_user: bool,
}

/// Cloning of boxed [`Metadata`].
pub(crate) trait CloneMetadata {
    fn clone_boxed(&self) -> Box<dyn Metadata>;
}

impl<M: Metadata + Clone + 'static> CloneMetadata for M {
    fn clone_boxed(&self) -> Box<dyn Metadata> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn Metadata> {
    fn clone(&self) -> Self {
        (**self).clone_boxed()
    }
}

/// Returns the planes of interleaved samples, each sample converted by `convert`.
pub(crate) fn deinterleave<T: Copy>(
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

/// Returns the channel names of an image of `channels` channels: grey or colour, without or with alpha.
pub(crate) fn channel_names(channels: usize) -> Vec<String> {
    let names: &[&str] = match channels {
        1 => &["Y"],
        2 => &["Y", "A"],
        3 => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    names.iter().map(|&n| n.to_owned()).collect()
}
