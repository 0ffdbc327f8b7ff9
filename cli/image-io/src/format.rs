//! An image format: its name, how it is recognised, and what it can store.

use std::fmt;
use std::path::Path;

use crate::error::{FileError, Result};
use crate::samples::SampleFormat;

/// An image format: a constant in the file or folder of each.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// Name for messages.
    pub(crate) name: &'static str,
    /// Name in lists of formats that are written.
    pub(crate) short_name: &'static str,
    /// File name extensions in lower case without the dot, the preferred one first.
    pub(crate) extensions: &'static [&'static str],
    /// The bytes that files begin with: one of these.
    pub(crate) magic: &'static [&'static [u8]],
    /// The samples of a plate of another format, for the help of commands; `None` if the format is read only.
    pub(crate) written_as: Option<&'static str>,
    /// Returns the sample format in which samples of a format are stored, in an image of that many channels. Half float
    /// stands for float if a sample exceeds its range.
    pub(crate) sample_format: fn(SampleFormat, usize) -> SampleFormat,
    pub(crate) capabilities: Capabilities,
}

/// The capabilities of a format. A conversion adapts the image to it and warns about everything else.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Capabilities {
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

impl Capabilities {
    /// The capabilities of a format that stores three colours alone.
    pub(crate) const RGB: Self = Self {
        layers: false,
        data_window: false,
        pixel_aspect: false,
        alpha: AlphaSupport::None,
        grey: GreySupport::Never,
        icc_profile: false,
        texts: false,
        common_metadata: false,
    };
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

impl Format {
    /// Returns the preferred file name extension, in lower case without the dot.
    pub fn extension(self) -> &'static str {
        self.extensions[0]
    }

    /// Returns whether plates are written in the format.
    pub fn is_writable(self) -> bool {
        self.written_as.is_some()
    }

    /// Returns whether a file may hold several layers and views.
    pub fn has_layers(self) -> bool {
        self.capabilities.layers
    }

    /// Returns whether images have a data window, so that they may exceed the frame.
    pub fn has_data_window(self) -> bool {
        self.capabilities.data_window
    }

    /// Returns whether a file name has an extension of the format.
    pub(crate) fn is_name(self, path: &Path) -> bool {
        let extension = path.extension().and_then(|extension| extension.to_str());
        extension.is_some_and(|own| self.extensions.contains(&&*own.to_ascii_lowercase()))
    }

    /// Checks that the name of an output file has an extension of the format, the only one it is written in.
    ///
    /// # Errors
    /// Another extension.
    pub fn check_name(self, path: &Path) -> Result<()> {
        if self.is_name(path) {
            return Ok(());
        }
        Err(FileError::new(
            path,
            "",
            format!("is written as {self} only, but has another extension"),
            format!("give it the extension .{}", self.extension()),
        ))
    }
}

impl PartialEq for Format {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}
