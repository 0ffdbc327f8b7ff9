//! The background of a plate: the plate without its foreground, and its depth.

use std::path::Path;

use seidel_core::{Background, Depth, DepthPass, PreparedBackground};

use super::{LoadedPlate, PlateReader};
use crate::commands::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::{ChannelSpec, ImageChannel};

/// The files of a background: paths or frame patterns.
pub(crate) struct BackgroundSource {
    pub(crate) plate: Option<String>,
    pub(crate) depth: Option<ChannelSpec>,
}

impl BackgroundSource {
    /// The files that the options `--background` and `--background-depth` name.
    pub(crate) fn new(plate: Option<&str>, depth: Option<&str>) -> Self {
        Self {
            plate: plate.map(str::to_owned),
            depth: depth.map(ChannelSpec::parse),
        }
    }

    /// Returns the paths or frame patterns of plate and depth, in this order, as far as they are used.
    pub(crate) fn file_patterns(&self) -> impl Iterator<Item = &str> {
        let depth = self.depth.as_ref().map(|spec| spec.file.as_str());
        self.plate.as_deref().into_iter().chain(depth)
    }

    /// Reads the background `file`, and its depth from the file `depth` or its own channel, and adds it to the plate
    /// `loaded`, warnings included.
    ///
    /// # Errors
    /// A background of another frame or without depth, and a plate at one distance, which uncovers nothing.
    pub(crate) fn add(
        &self,
        reader: &PlateReader,
        loaded: &mut LoadedPlate,
        file: &Path,
        depth: Option<&Path>,
    ) -> Result<(), CommandError> {
        if loaded.prepared.depth().pass().is_none() {
            return Err(FileError::new(
                file,
                "background",
                "is given, but the plate lies at one distance, where nothing hides it",
                "give the depth pass of the plate with --depth, or leave out --background",
            )
            .into());
        }
        let (plate, image) = reader.read_beside(loaded, file)?;
        let pass = match depth {
            Some(file) => {
                let channel = self.depth.as_ref().and_then(|spec| spec.channel.as_deref());
                ImageChannel::read_depth(file, channel)?
            }
            None => plate.depth(None).map_err(|e| {
                FileError::new(
                    file,
                    "depth",
                    e.problem(),
                    "give its depth pass with --background-depth FILE",
                )
            })?,
        };
        let fitted = pass.fit_to(loaded.plate.windows())?;
        loaded.warnings.extend(fitted.warning);
        let background = Background {
            image,
            depth: Depth::Pass(DepthPass {
                samples: fitted.samples,
                meaning: reader.depth_meaning,
            }),
        };
        let session = &loaded.lens.session;
        let added = PreparedBackground::new(session, loaded.prepared.geometry(), background)
            .and_then(|background| loaded.prepared.set_background(background));
        Ok(added.map_err(|e| FileError::from_core(file, e))?)
    }
}
