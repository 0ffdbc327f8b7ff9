//! The list of image formats: a file's format by its content or its name.

pub(crate) mod dpx;
pub mod exr;
mod hdr;
mod jpeg;
pub mod png;
pub(crate) mod tiff;

use std::io::Read;
use std::path::Path;

use self::exr::ExrImage;
use crate::error::{FileError, Result};
use crate::format::Format;
use crate::image_file::{ImageFile, ImageFormat};
use crate::input::{InputFile, Limits, open_file};
use crate::raster::RasterImage;

/// A format and its implementation.
pub(crate) type Row = (Format, &'static dyn ImageFormat);

/// Every format, in the order in which messages name them.
static ALL: [Row; 6] = [
    (exr::FORMAT, &exr::OpenExr),
    (png::FORMAT, &png::Png),
    (tiff::FORMAT, &tiff::Tiff),
    (dpx::FORMAT, &dpx::Dpx),
    (hdr::FORMAT, &hdr::Hdr),
    (jpeg::FORMAT, &jpeg::Jpeg),
];

/// Number of bytes at the start of a file that identify its format.
const MAGIC_BYTES: u64 = 8;

impl Format {
    /// Returns every format.
    pub fn all() -> impl Iterator<Item = Self> {
        ALL.iter().map(|(format, _)| *format)
    }

    /// Returns every format that plates are written in.
    pub fn writable() -> impl Iterator<Item = Self> {
        Self::all().filter(|format| format.is_writable())
    }

    /// Returns the format of a file name by its extension.
    pub fn from_path(path: &Path) -> Option<Self> {
        Self::all().find(|format| format.is_name(path))
    }
}

/// Returns the row of an existing file by its first bytes, whatever its extension.
///
/// # Errors
/// A file that cannot be read, is empty, or is in no supported format.
pub(crate) fn row_of_file(path: &Path) -> Result<Row> {
    let unreadable = |error: &std::io::Error| FileError::io(path, "be read", error);
    let file = open_file(path)?;
    let mut start = Vec::new();
    file.take(MAGIC_BYTES)
        .read_to_end(&mut start)
        .map_err(|e| unreadable(&e))?;
    let has_magic = |format: &Format| format.magic.iter().any(|magic| start.starts_with(magic));
    if let Some(row) = ALL.iter().find(|(format, _)| has_magic(format)) {
        return Ok(*row);
    }
    let problem = match Format::from_path(path) {
        _ if start.is_empty() => "is empty".to_owned(),
        Some(format) => {
            format!("has the extension of {format} but other content (damaged or truncated?)")
        }
        None => "is in no supported image format".to_owned(),
    };
    let names = Format::all().map(|format| {
        let extensions: Vec<String> = (format.extensions.iter())
            .map(|extension| format!(".{extension}"))
            .collect();
        format!("{format} ({})", extensions.join(", "))
    });
    let remedy = format!("use {}", alternatives(names));
    Err(FileError::new(path, "", problem, remedy))
}

/// Returns the format of an existing file by its first bytes, whatever its extension.
///
/// # Errors
/// A file that cannot be read, is empty, or is in no supported format.
pub fn detect(path: &Path) -> Result<Format> {
    Ok(row_of_file(path)?.0)
}

/// Returns the row of the format in which a plate called `path` is written, by its extension.
///
/// # Errors
/// A format that is read only, and an extension of no format.
pub(crate) fn output_row(path: &Path) -> Result<Row> {
    let problem = match ALL.iter().find(|(format, _)| format.is_name(path)) {
        Some(row) if row.0.is_writable() => return Ok(*row),
        Some((format, _)) => format!("would be {format}, which is never written"),
        None => "has no extension of a format that is written".to_owned(),
    };
    let extensions = Format::writable().map(|format| format!(".{}", format.extensions[0]));
    let remedy = format!("give it the extension {}", alternatives(extensions));
    Err(FileError::new(path, "", problem, remedy))
}

/// Returns the format in which a plate called `path` is written, by its extension.
///
/// # Errors
/// A format that is read only, and an extension of no format.
pub fn output_format(path: &Path) -> Result<Format> {
    Ok(output_row(path)?.0)
}

/// Returns the names of all formats, as `A, B or C`.
pub fn names_read() -> String {
    alternatives(Format::all().map(|format| format.name.to_owned()))
}

/// Returns the short names of the formats that are written, as `A, B or C`.
pub fn names_written() -> String {
    alternatives(Format::writable().map(|format| format.short_name.to_owned()))
}

/// Returns a sentence for each format that is written: how it stores a plate of another format.
pub fn written_samples() -> String {
    let sentence = |format: Format| {
        Some(format!(
            "{} gets {}.",
            format.short_name, format.written_as?
        ))
    };
    Format::all()
        .filter_map(sentence)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Joins words as `a, b or c`.
fn alternatives(words: impl Iterator<Item = String>) -> String {
    match &words.collect::<Vec<_>>()[..] {
        [first @ .., last] if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        words => words.concat(),
    }
}

impl ImageFile {
    /// Reads an image file of any format, recognised by its content.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, exceeds `limits`, or is in no supported format.
    pub(crate) fn open(path: &Path, limits: Limits) -> Result<Self> {
        let (format, implementation) = row_of_file(path)?;
        InputFile::open(path, format, limits)?.guarded(|input| implementation.read(input))
    }
}

impl ExrImage {
    /// Reads an OpenEXR file.
    ///
    /// Parts in a lossy compression are written with ZIP, so that pixels that are not replaced stay the same;
    /// [`ExrImage::warnings`] tells which.
    ///
    /// # Errors
    /// A file that cannot be read or is in another format, and deep, subsampled or otherwise unsupported images.
    pub fn open(path: &Path) -> Result<Self> {
        match ImageFile::open(path, Limits::PLATE)? {
            ImageFile::Exr(image) => Ok(*image),
            ImageFile::Raster(image) => Err(FileError::new(
                path,
                "",
                format!("is a {} file", image.format()),
                "give an OpenEXR file here",
            )),
        }
    }
}

impl RasterImage {
    /// Reads a file of a format that stores a single image, recognised by content.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, or is in another format.
    pub fn open(path: &Path) -> Result<Self> {
        match ImageFile::open(path, Limits::PLATE)? {
            ImageFile::Raster(image) => Ok(*image),
            ImageFile::Exr(_) => {
                let others = Format::all().filter(|format| !format.capabilities.layers);
                let names = alternatives(others.map(|format| format.short_name.to_owned()));
                let remedy = format!("give a {names} file here");
                Err(FileError::new(path, "", "is an OpenEXR file", remedy))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_differ_by_name_extensions_and_first_bytes() {
        for format in Format::all() {
            assert!(format.magic.iter().all(|m| m.len() as u64 <= MAGIC_BYTES));
            assert_eq!(Format::all().filter(|other| *other == format).count(), 1);
            for extension in format.extensions {
                let path = format!("a.{}", extension.to_uppercase());
                assert_eq!(Format::from_path(Path::new(&path)), Some(format));
            }
        }
        assert_eq!(Format::from_path(Path::new("a.gif")), None);
    }

    #[test]
    fn the_guide_has_a_row_for_every_format() {
        let page = include_str!("../../../docs/guide/files.md");
        for format in Format::all() {
            assert!(page.contains(&format!("\n| {format} | ")), "{format}");
        }
    }
}
