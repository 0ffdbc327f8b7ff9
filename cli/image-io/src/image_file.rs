//! Image files in memory, and the trait that every format implements.

use std::path::Path;

use crate::error::Result;
use crate::formats::exr::image::ExrImage;
use crate::input::InputFile;
use crate::new_image::NewImage;
use crate::part::Part;
use crate::raster::RasterImage;

/// An image file in memory, with its metadata.
#[derive(Debug, Clone)]
pub(crate) enum ImageFile {
    /// OpenEXR: parts with any channels.
    Exr(Box<ExrImage>),
    /// A format that stores a single image.
    Raster(Box<RasterImage>),
}

impl From<RasterImage> for ImageFile {
    fn from(image: RasterImage) -> Self {
        Self::Raster(Box::new(image))
    }
}

/// A file format that is read and perhaps written. Each is a file or folder of its own, and an entry of the list in
/// [`crate::formats`].
pub(crate) trait ImageFormat: Sync {
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
