//! Options about the background: the plate without its foreground, and its depth.

use std::path::Path;

use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use seidel_core::{Background, Depth, DepthPass, PreparedBackground};

use crate::commands::CommandError;
use crate::commands::plates::{LoadedPlate, PlateReader};
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::{ChannelSpec, ImageChannel};

/// Options about the background.
#[derive(Debug, Args)]
#[command(next_help_heading = "Depth")]
pub(super) struct BackgroundArgs {
    /// The plate without its foreground (a clean plate), or a frame pattern: shown where the blur of the foreground uncovers
    /// it, instead of an estimate
    ///
    /// Its depth is its own Z channel or --background-depth, with the meaning of the plate's.
    #[arg(long, value_name = "FILE", conflicts_with = "no_fill_foreground", value_parser = NonEmptyStringValueParser::new())]
    background: Option<String>,
    /// Depth pass of the background, or a frame pattern
    #[arg(long, value_name = "FILE[:CHANNEL]", requires = "background", value_parser = NonEmptyStringValueParser::new())]
    background_depth: Option<String>,
}

/// The files of a background: paths or frame patterns.
pub(super) struct BackgroundSource {
    pub(super) plate: Option<String>,
    pub(super) depth: Option<ChannelSpec>,
}

impl BackgroundArgs {
    /// Returns whether a background is given.
    pub(super) fn is_used(&self) -> bool {
        self.background.is_some()
    }

    /// Returns the files of the background.
    pub(super) fn source(&self) -> BackgroundSource {
        BackgroundSource {
            plate: self.background.clone(),
            depth: self.background_depth.as_deref().map(ChannelSpec::parse),
        }
    }
}

impl BackgroundSource {
    /// Returns the paths or frame patterns of plate and depth, in this order, as far as they are used.
    pub(super) fn file_patterns(&self) -> impl Iterator<Item = &str> {
        let depth = self.depth.as_ref().map(|spec| spec.file.as_str());
        self.plate.as_deref().into_iter().chain(depth)
    }

    /// Reads the background `file` of the plate `loaded`, and its depth from the file `depth` or its own channel. Adds
    /// warnings to the plate.
    ///
    /// # Errors
    /// A background of another frame or without depth, and a plate at one distance, which uncovers nothing.
    pub(super) fn read(
        &self,
        reader: &PlateReader,
        loaded: &mut LoadedPlate,
        file: &Path,
        depth: Option<&Path>,
    ) -> Result<PreparedBackground, CommandError> {
        if loaded.prepared.depth().pass().is_none() {
            return Err(FileError::new(
                file,
                "background",
                "is given, but the plate lies at one distance, where nothing is uncovered",
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
        let prepared = PreparedBackground::new(session, loaded.prepared.geometry(), background);
        Ok(prepared.map_err(|e| FileError::from_core(file, e))?)
    }
}
