//! Look-up tables: which kinds are written, and writing them.

use std::io::Write;
use std::path::Path;

use crate::atomic::write_whole;
use crate::error::Result;

/// The kinds of tables that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LutKind {
    /// Three-dimensional, of Iridas and Resolve: `.cube`.
    Cube,
    /// One-dimensional, of Sony Pictures Imageworks: `.spi1d`.
    Spi1d,
}

impl LutKind {
    /// The kind that a file name stands for, by its extension.
    pub fn of_name(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "cube" => Some(Self::Cube),
            "spi1d" => Some(Self::Spi1d),
            _ => None,
        }
    }
}

/// Writes the text of a table whole or not at all.
///
/// # Errors
/// A target that cannot be written.
pub fn write_lut(path: &Path, text: &str) -> Result<()> {
    write_whole(path, |out| out.write_all(text.as_bytes()))
}
