//! A part of an image file as it is described to users.

use serde::Serialize;

use crate::metadata::TextAttributes;

/// The description of a part of a file; only OpenEXR files have several.
#[derive(Debug, Clone, Serialize)]
pub struct Part {
    /// The name of the part, if it has one.
    pub name: Option<String>,
    /// Width and height of the data window, pixels.
    pub size: (usize, usize),
    /// Channels, each with its sample type.
    pub channels: TextAttributes,
    /// Storage of the pixels: compression, sample format and the like.
    pub storage: TextAttributes,
    /// Further metadata.
    pub attributes: TextAttributes,
    /// Provenance that Seidel has written.
    pub provenance: TextAttributes,
}
