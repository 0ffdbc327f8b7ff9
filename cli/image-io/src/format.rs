//! Which image format a file is, by its first bytes and its name.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{FileError, Result};

/// The image formats that are read, and but for JPEG written.
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

/// What is read, for messages.
const SUPPORTED: &str = "use OpenEXR (.exr), PNG (.png), TIFF (.tif, .tiff), DPX (.dpx), Radiance HDR (.hdr) or JPEG (.jpg)";

/// What is written, for messages.
const WRITTEN: &str = "give it the extension .exr, .png, .tif, .dpx or .hdr";

impl Format {
    /// The format that a file name stands for, by its extension.
    pub fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "exr" => Some(Self::Exr),
            "png" => Some(Self::Png),
            "tif" | "tiff" => Some(Self::Tiff),
            "dpx" => Some(Self::Dpx),
            "hdr" => Some(Self::Hdr),
            "jpg" | "jpeg" => Some(Self::Jpeg),
            _ => None,
        }
    }

    fn of_magic(start: &[u8]) -> Option<Self> {
        const PNG: [u8; 8] = [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n'];
        // Little and big endian, classic and BigTIFF.
        const TIFF: [[u8; 4]; 4] = [*b"II*\0", *b"MM\0*", *b"II+\0", *b"MM\0+"];
        if start.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            Some(Self::Exr)
        } else if start.starts_with(&PNG) {
            Some(Self::Png)
        } else if TIFF.iter().any(|magic| start.starts_with(magic)) {
            Some(Self::Tiff)
        } else if start.starts_with(b"SDPX") || start.starts_with(b"XPDS") {
            Some(Self::Dpx)
        } else if start.starts_with(b"#?RADIAN") || start.starts_with(b"#?RGBE") {
            Some(Self::Hdr)
        } else if start.starts_with(&[0xff, 0xd8, 0xff]) {
            Some(Self::Jpeg)
        } else {
            None
        }
    }

    fn extension(self) -> &'static str {
        match self {
            Self::Exr => ".exr",
            Self::Png => ".png",
            Self::Tiff => ".tif",
            Self::Dpx => ".dpx",
            Self::Hdr => ".hdr",
            Self::Jpeg => ".jpg",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Exr => "OpenEXR",
            Self::Png => "PNG",
            Self::Tiff => "TIFF",
            Self::Dpx => "DPX",
            Self::Hdr => "Radiance HDR",
            Self::Jpeg => "JPEG",
        })
    }
}

/// The format of an existing file, by its content. The name alone does not decide, so that a wrongly
/// named file is still read.
///
/// # Errors
/// A file that cannot be read, is empty, or is of no supported format.
pub fn detect(path: &Path) -> Result<Format> {
    let unreadable = |error: &std::io::Error| FileError::io(path, "be read", error);
    let file = File::open(path).map_err(|e| unreadable(&e))?;
    let mut start = Vec::new();
    file.take(8)
        .read_to_end(&mut start)
        .map_err(|e| unreadable(&e))?;
    if let Some(format) = Format::of_magic(&start) {
        return Ok(format);
    }
    let problem = match Format::of_name(path) {
        _ if start.is_empty() => "is empty".to_owned(),
        Some(format) => format!("is named like {format} but is none (damaged or truncated?)"),
        None => "is of no supported image format".to_owned(),
    };
    Err(FileError::new(path, "", problem, SUPPORTED))
}

/// The format in which a plate called `path` will be written, by its extension.
///
/// # Errors
/// JPEG, which is never written, and a name that stands for no format.
pub fn output_format(path: &Path) -> Result<Format> {
    let problem = match Format::of_name(path) {
        Some(Format::Jpeg) => "would be JPEG, which loses quality and is never written",
        Some(format) => return Ok(format),
        None => "is named like no format that plates are written in",
    };
    Err(FileError::new(path, "", problem, WRITTEN))
}

/// Checks that an output file's name stands for `format`, the only one it is written in.
///
/// # Errors
/// Another extension.
pub fn check_output_name(path: &Path, format: Format) -> Result<()> {
    if Format::of_name(path) == Some(format) {
        return Ok(());
    }
    Err(FileError::new(
        path,
        "",
        format!("is written as {format} only, but is not named so"),
        format!("give it the extension {}", format.extension()),
    ))
}
