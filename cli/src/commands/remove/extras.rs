//! What is written beside the sharp plate: residual and maps.

use std::path::PathBuf;

use seidel_image_io::error::Result;
use seidel_image_io::exr::{NewChannel, write_channels};
use seidel_image_io::residual::Residual;
use seidel_image_io::windows::ImageWindows;

/// One number a pixel of the plate, for each colour.
pub(super) struct Map {
    pub(super) path: PathBuf,
    /// Where the plate lies.
    pub(super) windows: ImageWindows,
    /// Names of the colours.
    pub(super) names: Vec<String>,
    pub(super) planes: Vec<Vec<f32>>,
}

/// A file to be written.
pub(super) enum Extra {
    Residual(Box<Residual>),
    Map(Map),
}

impl Extra {
    /// Writes it whole or not at all.
    pub(super) fn write(&self) -> Result<()> {
        match self {
            Self::Residual(residual) => residual.write(&residual.path),
            Self::Map(map) => {
                let pairs = map.names.iter().zip(&map.planes);
                let channels: Vec<NewChannel> = pairs
                    .map(|(name, samples)| NewChannel {
                        name,
                        samples,
                        half: false,
                    })
                    .collect();
                write_channels(&map.path, map.windows, &channels)
            }
        }
    }
}
