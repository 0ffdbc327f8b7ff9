//! An image that was converted to what a format can store.

use std::path::PathBuf;

use crate::format::Format;
use crate::formats::exr::compression::ExrCompression;
use crate::metadata::{CommonMetadata, TextAttributes};
use crate::raster::{Metadata, RasterImage};
use crate::samples::{Encoding, SampleFormat};
use crate::windows::ImageWindows;

/// An image that was converted to what a format can store.
#[derive(Debug, Clone)]
pub(crate) struct NewImage {
    pub(crate) format: Format,
    /// The path of the plate.
    pub(crate) path: PathBuf,
    pub(crate) windows: ImageWindows,
    pub(crate) pixel_aspect: f64,
    /// Names of the colour planes.
    pub(crate) names: Vec<String>,
    /// Code values, row-major over the data window.
    pub(crate) colour: Vec<Vec<f32>>,
    pub(crate) alpha: Option<Vec<f32>>,
    pub(crate) premultiplied: bool,
    pub(crate) sample_format: SampleFormat,
    /// The encoding of the code values; `None` if they are of some colour space.
    pub(crate) encoding: Option<Encoding>,
    pub(crate) icc_profile: Option<Vec<u8>>,
    pub(crate) texts: TextAttributes,
    pub(crate) common: CommonMetadata,
    /// The colour space that colour was converted to, if it was converted.
    pub(crate) colour_space: Option<String>,
    pub(crate) compression: Option<ExrCompression>,
}

impl NewImage {
    /// Returns the number of channels.
    pub(crate) fn channels(&self) -> usize {
        self.colour.len() + usize::from(self.alpha.is_some())
    }

    /// Converts the image to one of a format that stores a single image.
    pub(crate) fn into_raster(self, metadata: impl Metadata + 'static) -> RasterImage {
        let alpha_name = self.alpha.as_ref().map(|_| "A".to_owned());
        RasterImage {
            format: self.format,
            path: self.path,
            metadata: Box::new(metadata),
            sample_format: self.sample_format,
            width: self.windows.data.width,
            height: self.windows.data.height,
            names: self.names.into_iter().chain(alpha_name).collect(),
            planes: self.colour.into_iter().chain(self.alpha).collect(),
            texts: self.texts,
            changed: true,
            warnings: Vec::new(),
        }
    }
}
