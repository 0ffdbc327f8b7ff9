//! The images read beside a plate: its depth, holdout, mask and background.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use seidel_core::{
    Background, Depth, DepthPass, Error, HoldoutMatte, LensSession, ObjectDistance, PlateGeometry,
    PreparedBackground, PreparedDepth, PreparedPlate,
};

use super::depth::{FrameOrder, describe, name_note};
use super::depth_check::check_depth;
use super::{LoadedPlate, PlateReader, SideInputs};
use crate::commands::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::{ChannelSpec, ImageChannel};
use seidel_image_io::plate::PlateFile;

/// A matte over the data window of a plate.
struct Matte {
    samples: Vec<f32>,
    /// The place of its samples in the file, for errors.
    channel: String,
}

/// The place of a depth pass.
pub(super) struct DepthSource {
    file: PathBuf,
    channel: String,
}

impl DepthSource {
    fn error(&self, error: Error) -> FileError {
        FileError::from_core(
            &self.file,
            error.within(&format!("channel {}", self.channel)),
        )
    }

    fn note(&self, note: impl Display) -> String {
        format!("depth {}:{} {note}", self.file.display(), self.channel)
    }
}

impl PlateReader<'_> {
    /// Reads the depth of `plate` for the lens of `session`: from `file`, or else from the plate. Returns the place of the pass
    /// too, if it is one. Adds to `warnings`.
    pub(super) fn read_depth(
        &self,
        plate: &PlateFile,
        geometry: &PlateGeometry,
        file: Option<&ChannelSpec>,
        session: &LensSession,
        order: FrameOrder,
        warnings: &mut Vec<String>,
    ) -> Result<(PreparedDepth, Option<DepthSource>), CommandError> {
        let options = &self.args.depth;
        let prepare = |depth| PreparedDepth::new(session, geometry, depth);
        let is_flat = !session.lens().predictor().depends_on_depth();
        let distance = (options.distance).or(is_flat.then_some(ObjectDistance::Unknown));
        if let Some(distance) = distance {
            return Ok((prepare(Depth::Distance(distance))?, None));
        }
        let remedy = "the lens's blur depends on depth: give --depth FILE or --distance METRES";
        let pass = read_pass(plate, file, remedy)?;
        if file.is_none() && order == FrameOrder::First {
            warnings.extend(plate.other_depths_note());
        }
        let depth = prepare(Depth::Pass(self.fit_pass(&pass, plate, warnings)?));
        let source = DepthSource {
            file: pass.file,
            channel: pass.channel,
        };
        let depth = depth.map_err(|e| source.error(e))?;
        let notes = (depth.reading()).map_or_else(Vec::new, |reading| describe(reading, order));
        warnings.extend(notes.into_iter().map(|note| source.note(note)));
        Ok((depth, Some(source)))
    }

    /// Returns doubts about the depth pass from `source` with which `plate` is prepared.
    ///
    /// # Errors
    /// A perspective that is not valid.
    pub(super) fn depth_doubts(
        &self,
        source: &DepthSource,
        plate: &PreparedPlate,
    ) -> Result<Vec<String>, FileError> {
        let doubts = check_depth(plate).map_err(|e| source.error(e))?;
        let of_name = name_note(&source.channel, self.depth_meaning);
        let notes = of_name.into_iter().chain(doubts);
        Ok(notes.map(|note| source.note(note)).collect())
    }

    /// Reads holdout, mask and background from `files` and adds them to the plate `loaded`, warnings included.
    ///
    /// # Errors
    /// A matte that is not one, a background of another frame or without depth, and a background of a plate at one distance.
    pub(crate) fn add_side_images(
        &self,
        files: &SideInputs,
        loaded: &mut LoadedPlate,
    ) -> Result<(), CommandError> {
        if let Some(matte) = &files.holdout {
            self.add_holdout(matte, files.holdout_depth.as_ref(), loaded)?;
        }
        if let Some(mask) = &files.mask {
            let mut matte = self.read_matte(mask, loaded)?;
            if files.invert_mask {
                matte
                    .samples
                    .iter_mut()
                    .for_each(|value| *value = 1.0 - *value);
            }
            let added = loaded.prepared.set_mask(matte.samples);
            added.map_err(|e| FileError::from_core(&mask.file, e.within(&matte.channel)))?;
        }
        if let Some(file) = &files.background {
            self.add_background(file, files.background_depth.as_ref(), loaded)?;
        }
        Ok(())
    }

    /// Reads a matte over the data window of the plate `loaded`. Adds to its warnings.
    fn read_matte(
        &self,
        matte: &ChannelSpec,
        loaded: &mut LoadedPlate,
    ) -> Result<Matte, CommandError> {
        let image = ImageChannel::read_matte(&matte.file, matte.channel.as_deref())?;
        let fitted = image.fit_to(loaded.plate.windows())?;
        loaded.warnings.extend(fitted.warning);
        Ok(Matte {
            samples: fitted.samples,
            channel: format!("channel {}", image.channel),
        })
    }

    fn add_holdout(
        &self,
        matte: &ChannelSpec,
        depth: Option<&ChannelSpec>,
        loaded: &mut LoadedPlate,
    ) -> Result<(), CommandError> {
        let Matte { samples, channel } = self.read_matte(matte, loaded)?;
        let mut holdout = HoldoutMatte {
            samples,
            depth: None,
        };
        (holdout.check(loaded.plate.width()))
            .map_err(|e| FileError::from_core(&matte.file, e.within(&channel)))?;
        if let Some(depth) = depth {
            let pass = (loaded.plate).read_depth(&depth.file, depth.channel.as_deref())?;
            holdout.depth = Some(self.fit_pass(&pass, &loaded.plate, &mut loaded.warnings)?);
        }
        let file = &depth.unwrap_or(matte).file;
        let added = loaded.prepared.set_holdout(holdout);
        Ok(added.map_err(|e| FileError::from_core(file, e))?)
    }

    fn add_background(
        &self,
        file: &Path,
        depth: Option<&ChannelSpec>,
        loaded: &mut LoadedPlate,
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
        let (plate, image) = self.read_beside(loaded, file)?;
        let remedy = "give its depth pass with --background-depth FILE";
        let pass = read_pass(&plate, depth, remedy)?;
        let pass = self.fit_pass(&pass, &loaded.plate, &mut loaded.warnings)?;
        let background = Background {
            image,
            depth: Depth::Pass(pass),
        };
        let session = &loaded.lens.session;
        let added = PreparedBackground::new(session, loaded.prepared.geometry(), background)
            .and_then(|background| loaded.prepared.set_background(background));
        Ok(added.map_err(|e| FileError::from_core(file, e))?)
    }

    /// Fits a depth pass to the data window of `plate`. Adds to `warnings`.
    fn fit_pass(
        &self,
        pass: &ImageChannel,
        plate: &PlateFile,
        warnings: &mut Vec<String>,
    ) -> Result<DepthPass, FileError> {
        let fitted = pass.fit_to(plate.windows())?;
        warnings.extend(fitted.warning);
        Ok(DepthPass {
            samples: fitted.samples,
            meaning: self.depth_meaning,
        })
    }
}

/// Reads a depth pass from `file`, or else from `plate`; `remedy` is for a plate without one.
fn read_pass(
    plate: &PlateFile,
    file: Option<&ChannelSpec>,
    remedy: &str,
) -> Result<ImageChannel, FileError> {
    match file {
        Some(pass) => plate.read_depth(&pass.file, pass.channel.as_deref()),
        None => (plate.depth(None))
            .map_err(|e| FileError::new(plate.path(), "depth", e.problem(), remedy)),
    }
}
