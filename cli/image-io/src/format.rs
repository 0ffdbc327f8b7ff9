//! The image formats: how each is recognised, read and written, and what it can store.

use std::fmt;
use std::io::Read;
use std::path::Path;

use crate::description::Part;
use crate::error::{FileError, Result};
use crate::exr::{ExrImage, OpenExr};
use crate::input::{InputFile, Limits, open_file};
use crate::plate::NewImage;
use crate::raster::RasterImage;
use crate::samples::SampleFormat;
use crate::{dpx, hdr, jpeg, png, tiff};

/// A supported image format. All are read; all but JPEG are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: `.exr`.
    Exr,
    /// PNG: `.png`.
    Png,
    /// TIFF: `.tif`, `.tiff`.
    Tiff,
    /// DPX (SMPTE 268M): `.dpx`.
    Dpx,
    /// Radiance RGBE: `.hdr`.
    Hdr,
    /// JPEG: `.jpg`, `.jpeg`. Read only.
    Jpeg,
}

/// The implementation of every format, in the order of [`Format`].
static IMPLEMENTATIONS: [&dyn ImageFormat; 6] = [
    &OpenExr,
    &png::Png,
    &tiff::Tiff,
    &dpx::Dpx,
    &hdr::Hdr,
    &jpeg::Jpeg,
];

/// A file format. Each has a folder of its own; a new one is added there, to [`Format`] and to [`IMPLEMENTATIONS`].
pub(crate) trait ImageFormat: Sync {
    /// Returns the name of the format, how it is recognised and what it can store.
    fn info(&self) -> &'static FormatInfo;

    /// Returns the sample format in which samples of format `source` are stored, in an image of `channels` channels.
    /// Half float stands for float if a sample exceeds its range.
    fn sample_format(&self, source: SampleFormat, channels: usize) -> SampleFormat;

    /// Reads a file with its metadata.
    ///
    /// # Errors
    /// A file that is damaged, exceeds the limits, or uses features that are not supported.
    fn read(&self, input: &InputFile) -> Result<ImageFile>;

    /// Describes the parts of a file; by default its only image, after reading all of it.
    ///
    /// # Errors
    /// Those of [`ImageFormat::read`].
    fn describe(&self, input: &InputFile) -> Result<Vec<Part>> {
        match self.read(input)? {
            ImageFile::Raster(image) => Ok(vec![image.describe()]),
            // OpenEXR describes its parts from the headers alone.
            ImageFile::Exr(_) => Ok(Vec::new()),
        }
    }

    /// Writes an image that was converted to this format, whole or not at all. Returns warnings about what the file
    /// cannot store.
    ///
    /// # Errors
    /// A format that is read only, and a file that cannot be written.
    fn write_new(&self, path: &Path, image: NewImage) -> Result<Vec<String>>;
}

/// The name of a format, how it is recognised and what it can store.
pub(crate) struct FormatInfo {
    pub(crate) id: Format,
    /// Name for messages.
    pub(crate) name: &'static str,
    /// File name extensions in lower case without the dot, the preferred one first.
    pub(crate) extensions: &'static [&'static str],
    /// The bytes that files begin with, at most [`MAGIC_BYTES`]: one of these.
    pub(crate) magic: &'static [&'static [u8]],
    pub(crate) capabilities: Capabilities,
}

/// The capabilities of a format. A conversion adapts the image to it and warns about everything else.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Capabilities {
    /// Whether plates are written in the format.
    pub(crate) writable: bool,
    /// Channels beside colour and alpha, parts, and attributes of any name.
    pub(crate) layers: bool,
    /// A data window that differs from the display window.
    pub(crate) data_window: bool,
    /// The pixel aspect ratio.
    pub(crate) pixel_aspect: bool,
    /// Alpha, and its relation to colour.
    pub(crate) alpha: AlphaSupport,
    /// Images of one colour channel.
    pub(crate) grey: GreySupport,
    /// An ICC profile.
    pub(crate) icc_profile: bool,
    /// Text metadata of any name; otherwise provenance only.
    pub(crate) texts: bool,
    /// [`CommonMetadata`](crate::metadata::CommonMetadata).
    pub(crate) common_metadata: bool,
}

/// The alpha that a format stores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AlphaSupport {
    /// Not at all; colour is stored premultiplied.
    None,
    /// Colour is premultiplied by alpha.
    Premultiplied,
    /// Colour is not multiplied by alpha.
    Unpremultiplied,
    /// The file states which.
    Either,
}

/// The images of one colour channel that a format stores; others store it as equal R, G and B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GreySupport {
    Always,
    WithoutAlpha,
    Never,
}

/// An image file in memory, with its metadata.
#[derive(Debug, Clone)]
pub(crate) enum ImageFile {
    /// OpenEXR: parts with any channels.
    Exr(Box<ExrImage>),
    /// A format that stores a single image.
    Raster(RasterImage),
}

/// Number of bytes at the start of a file that identify its format.
const MAGIC_BYTES: u64 = 8;

impl Format {
    /// Every format.
    pub const ALL: [Self; 6] = [
        Self::Exr,
        Self::Png,
        Self::Tiff,
        Self::Dpx,
        Self::Hdr,
        Self::Jpeg,
    ];

    /// Returns the format of a file name by its extension.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        let mut infos = IMPLEMENTATIONS.iter().map(|format| format.info());
        let named = infos.find(|info| info.extensions.contains(&extension.as_str()))?;
        Some(named.id)
    }

    /// Returns the file name extensions in lower case without the dot, the preferred one first.
    pub fn extensions(self) -> &'static [&'static str] {
        self.info().extensions
    }

    /// Returns whether plates are written in the format.
    pub fn is_writable(self) -> bool {
        self.info().capabilities.writable
    }

    pub(crate) fn info(self) -> &'static FormatInfo {
        self.implementation().info()
    }

    pub(crate) fn implementation(self) -> &'static dyn ImageFormat {
        IMPLEMENTATIONS[self as usize]
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.info().name)
    }
}

/// Returns the format of an existing file by its first bytes, whatever its extension.
///
/// # Errors
/// A file that cannot be read, is empty, or is in no supported format.
pub fn detect(path: &Path) -> Result<Format> {
    let unreadable = |error: &std::io::Error| FileError::io(path, "be read", error);
    let file = open_file(path)?;
    let mut start = Vec::new();
    file.take(MAGIC_BYTES)
        .read_to_end(&mut start)
        .map_err(|e| unreadable(&e))?;
    let mut infos = IMPLEMENTATIONS.iter().map(|format| format.info());
    let found = infos.find(|info| info.magic.iter().any(|magic| start.starts_with(magic)));
    if let Some(info) = found {
        return Ok(info.id);
    }
    let problem = match Format::from_path(path) {
        _ if start.is_empty() => "is empty".to_owned(),
        Some(format) => {
            format!("has the extension of {format} but other content (damaged or truncated?)")
        }
        None => "is in no supported image format".to_owned(),
    };
    let names = Format::ALL.map(|format| {
        let extensions: Vec<String> = (format.extensions().iter())
            .map(|extension| format!(".{extension}"))
            .collect();
        format!("{format} ({})", extensions.join(", "))
    });
    Err(FileError::new(
        path,
        "",
        problem,
        format!("use {}", alternatives(&names)),
    ))
}

/// Returns the format in which a plate called `path` is written, by its extension.
///
/// # Errors
/// JPEG, which is read only, and an extension of no format.
pub fn output_format(path: &Path) -> Result<Format> {
    let problem = match Format::from_path(path) {
        Some(format) if format.is_writable() => return Ok(format),
        Some(format) => format!("would be {format}, which is never written"),
        None => "has no extension of a format that is written".to_owned(),
    };
    let writable = Format::ALL
        .into_iter()
        .filter(|format| format.is_writable());
    let extensions: Vec<String> = writable
        .map(|format| format!(".{}", format.extensions()[0]))
        .collect();
    let remedy = format!("give it the extension {}", alternatives(&extensions));
    Err(FileError::new(path, "", problem, remedy))
}

/// Joins `words` as `a, b or c`.
fn alternatives(words: &[String]) -> String {
    match words {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        _ => words.concat(),
    }
}

/// Checks that the name of an output file has an extension of `format`, the only one it is written in.
///
/// # Errors
/// Another extension.
pub fn check_output_name(path: &Path, format: Format) -> Result<()> {
    if Format::from_path(path) == Some(format) {
        return Ok(());
    }
    Err(FileError::new(
        path,
        "",
        format!("is written as {format} only, but has another extension"),
        format!("give it the extension .{}", format.extensions()[0]),
    ))
}

impl ImageFile {
    /// Reads an image file of any format, recognised by its content.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, exceeds `limits`, or is in no supported format.
    pub(crate) fn open(path: &Path, limits: Limits) -> Result<Self> {
        let format = detect(path)?;
        InputFile::open(path, format, limits)?.guarded(|input| format.implementation().read(input))
    }
}

impl From<RasterImage> for ImageFile {
    fn from(image: RasterImage) -> Self {
        Self::Raster(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn implementations_stand_in_the_order_of_the_formats() {
        for format in Format::ALL {
            assert_eq!(format.info().id, format);
            assert!(
                format
                    .info()
                    .magic
                    .iter()
                    .all(|m| m.len() as u64 <= MAGIC_BYTES)
            );
            for extension in format.extensions() {
                let path = format!("a.{}", extension.to_uppercase());
                assert_eq!(Format::from_path(Path::new(&path)), Some(format));
            }
        }
        assert_eq!(Format::from_path(Path::new("a.gif")), None);
    }
}
