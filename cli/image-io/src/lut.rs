//! Look-up tables as files.

use std::io::Write;
use std::path::Path;

use crate::atomic::write_atomically;
use crate::error::Result;

/// The file format of a look-up table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LutFormat {
    /// Three-dimensional table of Iridas and Resolve: `.cube`.
    Cube,
    /// One-dimensional table of Sony Pictures Imageworks: `.spi1d`.
    Spi1d,
}

impl LutFormat {
    /// Returns the format of a file name by its extension.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "cube" => Some(Self::Cube),
            "spi1d" => Some(Self::Spi1d),
            _ => None,
        }
    }
}

/// Writes the text of a table, whole or not at all.
///
/// # Errors
/// A target that cannot be written.
pub fn write_lut(path: &Path, text: &str) -> Result<()> {
    write_atomically(path, |out| out.write_all(text.as_bytes()))
}
