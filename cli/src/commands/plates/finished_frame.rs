//! A processed frame and the files written beside it.

use std::path::{Path, PathBuf};

use super::SettingsRecord;
use super::queue::FrameResult;
use seidel_image_io::error::Result;
use seidel_image_io::formats::exr::{NewChannel, write_channels};
use seidel_image_io::plate::PlateFile;
use seidel_image_io::residual::Residual;
use seidel_image_io::windows::ImageWindows;

/// A processed frame with everything to write for it.
pub(crate) struct FinishedFrame {
    pub(crate) plate: PlateFile,
    /// Settings for the provenance.
    pub(crate) record: SettingsRecord,
    /// Files written before the plate.
    pub(crate) side_files: Vec<SideFile>,
    pub(crate) warnings: Vec<String>,
}

/// A file written beside the plate.
pub(crate) enum SideFile {
    Residual(Box<Residual>),
    Map(Map),
}

/// A map over the pixels of the plate, one plane per colour.
pub(crate) struct Map {
    pub(crate) path: PathBuf,
    /// Windows of the plate.
    pub(crate) windows: ImageWindows,
    /// Names of the colours.
    pub(crate) names: Vec<String>,
    pub(crate) planes: Vec<Vec<f32>>,
}

impl FinishedFrame {
    /// Writes the side files, then the plate to `path`, each whole or not at all. Returns all warnings.
    pub(super) fn write(self, path: &Path) -> FrameResult {
        for file in &self.side_files {
            file.write()?;
        }
        let mut warnings = self.warnings;
        warnings.extend(self.plate.write(path)?);
        Ok(warnings)
    }
}

impl SideFile {
    fn write(&self) -> Result<()> {
        match self {
            Self::Residual(residual) => residual.write(&residual.path),
            Self::Map(map) => {
                let channels = map.names.iter().zip(&map.planes);
                let channels: Vec<NewChannel> = channels
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
