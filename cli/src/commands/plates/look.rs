//! Options about the look of a lens: its iris, and the knobs of new blur.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use seidel_core::{AperturePicture, Blades, Bloom, LookPreset, Settings};

use super::animated;
use super::{SettingsRecord, setting};
use crate::commands::CommandError;
use crate::commands::knobs::NewBlurKnobs;
use seidel_image_io::animation::Animation;
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::ImageChannel;

/// Options about the look of a lens, all as the lens is by default.
#[derive(Debug, Args)]
#[command(next_help_heading = "Look")]
pub(crate) struct LookArgs {
    /// A look with a name: values for the options of this group but bloom. Those that are given as well come first
    #[arg(long, value_name = "NAME", value_parser = preset_names())]
    look: Option<String>,
    /// Iris blades: 3 to 13, or 0 for a round iris; those of the lens if omitted
    ///
    /// All looks but bloom need a lens of rays: one of the library, or one fitted with --model reduced or extended. They act on
    /// the lens as --f-number and --focus-distance set it.
    #[arg(long, value_name = "N", value_parser = parse_blades)]
    blades: Option<u32>,
    /// Picture of the aperture, white where light passes: background discs show it. Its shorter side is the width of the pupil
    ///
    /// Takes the mean of R, G and B, or the only channel, times A, as the file stores them. Finer detail than a 64th of the
    /// pupil is lost.
    #[arg(long, value_name = "FILE")]
    aperture_picture: Option<PathBuf>,
    #[command(flatten)]
    knobs: NewBlurKnobs,
}

fn parse_blades(text: &str) -> Result<u32, String> {
    let (least, most) = Blades::COUNTS;
    let count = text.trim().parse().ok();
    let count = count.filter(|count| *count == 0 || (least..=most).contains(count));
    count.ok_or_else(|| format!("give {least} to {most}, or 0 for a round iris"))
}

fn preset_names() -> PossibleValuesParser {
    let presets = LookPreset::all().iter();
    PossibleValuesParser::new(
        presets.map(|preset| PossibleValue::new(preset.name).help(preset.help)),
    )
}

impl LookArgs {
    fn preset(&self) -> Option<&'static LookPreset> {
        LookPreset::named(self.look.as_deref()?)
    }

    /// Returns the number of blades that is given, or else that of the preset.
    fn blade_count(&self) -> Option<u32> {
        self.blades.or_else(|| self.preset()?.blades)
    }

    /// Returns the numbers that are given, with those of the preset for the others.
    fn numbers(&self) -> NewBlurKnobs {
        match self.preset() {
            Some(preset) => self.knobs.with_defaults(preset.values()),
            None => self.knobs.clone(),
        }
    }

    /// Writes look and bloom to `settings`.
    ///
    /// # Errors
    /// A picture of the aperture that cannot be read or is black.
    pub(crate) fn put(&self, settings: &mut Settings) -> Result<(), CommandError> {
        let picture = self.aperture_picture.as_deref();
        settings.look.picture = picture.map(read_picture).transpose()?;
        settings.look.blades = self.blade_count().map(Blades::straight);
        Ok(self.numbers().put(settings)?)
    }

    /// Writes the numbers of look and bloom to `settings`, which have those of [`Self::put`], with the values that `table` has
    /// for `frame`.
    ///
    /// # Errors
    /// Values out of range.
    pub(super) fn put_at_frame(
        &self,
        table: &Animation,
        frame: i64,
        settings: &mut Settings,
    ) -> Result<(), CommandError> {
        let knobs = animated::at_frame(&self.numbers(), table, frame)?;
        Ok(knobs.put(settings)?)
    }

    /// Rejects a table that changes the curvature or the rotation of blades that no option gives.
    pub(super) fn check_blades(&self, table: &Animation) -> Result<(), CommandError> {
        let mut names = table.names();
        if self.blade_count().is_some()
            || !names.any(|name| name == "roundness" || name == "rotation")
        {
            return Ok(());
        }
        Err(FileError::new(
            table.path(),
            "roundness, rotation",
            "change no blades",
            "give --blades as well",
        )
        .into())
    }

    /// Returns the files that the look is read from.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.aperture_picture.as_deref().into_iter()
    }
}

/// Reads the picture of an aperture, once a run.
fn read_picture(file: &Path) -> Result<AperturePicture, FileError> {
    let read = ImageChannel::read_transmission(file)?;
    let width = read.windows.data.width;
    AperturePicture::new(width, &read.samples).map_err(|e| FileError::from_core(file, e))
}

/// Returns look and bloom of `settings` by name, as far as they change the lens or the plate.
pub(super) fn look_record(settings: &Settings) -> SettingsRecord {
    let mut record = Vec::new();
    if !settings.look.is_neutral() {
        record.push(setting("look", &settings.look));
    }
    if let Some(bloom) = &settings.bloom {
        let Bloom {
            share,
            level,
            radius,
        } = bloom;
        let percent = 100.0 * radius;
        record.push(setting(
            "bloom",
            format!("{share} above {level}, radius {percent} %"),
        ));
    }
    record
}
