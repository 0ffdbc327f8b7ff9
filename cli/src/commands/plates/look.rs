//! Options about the look of a lens: its iris, squeeze, obstruction, aberrations and bloom.

use std::path::{Path, PathBuf};

use clap::Args;
use seidel_core::{AperturePicture, Blades, Bloom, Look, LookRange, Settings};

use super::{SettingsRecord, setting};
use crate::commands::CommandError;
use seidel_image_io::animation::{Animation, Interpolation};
use seidel_image_io::error::FileError;
use seidel_image_io::image_channel::ImageChannel;

/// Options about the look of a lens, all as the lens is by default.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Look")]
pub(crate) struct LookArgs {
    /// Iris blades: 3 to 13, or 0 for a round iris; those of the lens if omitted
    ///
    /// All looks but bloom need a lens of rays: one of the library, or one fitted with --model reduced or extended. They act on
    /// the lens as --f-number and --focus-distance set it.
    #[arg(long, value_name = "N", value_parser = parse_blades)]
    blades: Option<u32>,
    /// Curvature of the blades, 0 (straight) to 1 (one circle)
    #[arg(long, value_name = "R", requires = "blades", default_value_t = 0.0, value_parser = parse_roundness)]
    roundness: f64,
    /// Direction of one corner of discs before the focus, degrees from right towards down, -180 to 180
    ///
    /// Discs behind the focus are turned by 180 degrees.
    #[arg(long, value_name = "DEGREES", requires = "blades", default_value_t = 0.0, allow_hyphen_values = true, value_parser = parse_rotation)]
    rotation: f64,
    /// Picture of the aperture, white where light passes: background discs show it. Its shorter side is the width of the pupil
    ///
    /// Takes the mean of R, G and B, or the only channel, times A, as the file stores them. Finer detail than a 64th of the
    /// pupil is lost.
    #[arg(long, value_name = "FILE")]
    aperture_picture: Option<PathBuf>,
    /// Height of discs over their width, 0.4 to 2.5, times that of the lens: 2 for the ovals of a 2x anamorphic lens
    #[arg(long, value_name = "S", default_value_t = Look::SQUEEZE.neutral, value_parser = parse_squeeze)]
    squeeze: f64,
    /// Radius of the dark middle of discs, 0 to 0.9 of theirs, as of a mirror lens
    #[arg(long, value_name = "R", default_value_t = Look::OBSTRUCTION.neutral, value_parser = parse_obstruction)]
    obstruction: f64,
    /// Cat's eyes towards the corners: -1 for round discs, 0 as the lens, 1 for strong ones
    #[arg(long, value_name = "C", default_value_t = Look::CATS_EYE.neutral, allow_hyphen_values = true, value_parser = parse_cats_eye)]
    cats_eye: f64,
    /// Spherical aberration added: -1 for soft discs behind the focus, 1 for bubbles with bright rims
    #[arg(long, value_name = "S", default_value_t = Look::SPHERICAL.neutral, allow_hyphen_values = true, value_parser = parse_spherical)]
    spherical: f64,
    /// Factor on the difference of focus between channels, -4 to 4: 0 for none, 1 as the lens
    #[arg(long, value_name = "F", default_value_t = Look::COLOUR.neutral, allow_hyphen_values = true, value_parser = parse_colour)]
    axial_colour: f64,
    /// Factor on the difference of magnification between channels, -4 to 4: 0 for none, 1 as the lens
    #[arg(long, value_name = "F", default_value_t = Look::COLOUR.neutral, allow_hyphen_values = true, value_parser = parse_colour)]
    lateral_colour: f64,
    /// Share of the light above --bloom-level that spreads around highlights, 0 to 1; any lens
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = parse_share)]
    bloom: f64,
    /// Scene-linear value above which light spreads
    #[arg(long, value_name = "VALUE", requires = "bloom", default_value_t = 1.0, value_parser = parse_level)]
    bloom_level: f64,
    /// Radius that holds half of the spread light, 0.05 to 20 % of the width of the frame
    #[arg(long, value_name = "PERCENT", requires = "bloom", default_value_t = 1.0, value_parser = parse_radius)]
    bloom_radius: f64,
}

/// A number of the look that an animation table can change.
pub(super) struct LookColumn {
    /// Its name, that of the option.
    pub(super) name: &'static str,
    /// Parses a value; gives a remedy for one out of range.
    parse: fn(&str) -> Result<f64, String>,
    option: fn(&mut LookArgs) -> &mut f64,
}

impl LookColumn {
    const fn new(
        name: &'static str,
        parse: fn(&str) -> Result<f64, String>,
        option: fn(&mut LookArgs) -> &mut f64,
    ) -> Self {
        Self {
            name,
            parse,
            option,
        }
    }
}

/// The numbers of the look that an animation table can change.
pub(super) const COLUMNS: [LookColumn; 11] = [
    LookColumn::new("roundness", parse_roundness, |args| &mut args.roundness),
    LookColumn::new("rotation", parse_rotation, |args| &mut args.rotation),
    LookColumn::new("squeeze", parse_squeeze, |args| &mut args.squeeze),
    LookColumn::new("obstruction", parse_obstruction, |args| {
        &mut args.obstruction
    }),
    LookColumn::new("cats-eye", parse_cats_eye, |args| &mut args.cats_eye),
    LookColumn::new("spherical", parse_spherical, |args| &mut args.spherical),
    LookColumn::new("axial-colour", parse_colour, |args| &mut args.axial_colour),
    LookColumn::new("lateral-colour", parse_colour, |args| {
        &mut args.lateral_colour
    }),
    LookColumn::new("bloom", parse_share, |args| &mut args.bloom),
    LookColumn::new("bloom-level", parse_level, |args| &mut args.bloom_level),
    LookColumn::new("bloom-radius", parse_radius, |args| &mut args.bloom_radius),
];

/// Parses a number within `range`.
fn within(text: &str, range: LookRange) -> Result<f64, String> {
    let value: f64 = text
        .trim()
        .parse()
        .map_err(|_| "give a number".to_owned())?;
    range.check("", value).map_err(|error| error.remedy)?;
    Ok(value)
}

fn parse_blades(text: &str) -> Result<u32, String> {
    let (least, most) = Blades::COUNTS;
    let count = text.trim().parse().ok();
    let count = count.filter(|count| *count == 0 || (least..=most).contains(count));
    count.ok_or_else(|| format!("give {least} to {most}, or 0 for a round iris"))
}

fn parse_roundness(text: &str) -> Result<f64, String> {
    within(text, Blades::ROUNDNESS)
}

fn parse_rotation(text: &str) -> Result<f64, String> {
    within(text, Blades::ROTATION_DEG)
}

fn parse_squeeze(text: &str) -> Result<f64, String> {
    within(text, Look::SQUEEZE)
}

fn parse_obstruction(text: &str) -> Result<f64, String> {
    within(text, Look::OBSTRUCTION)
}

fn parse_cats_eye(text: &str) -> Result<f64, String> {
    within(text, Look::CATS_EYE)
}

fn parse_spherical(text: &str) -> Result<f64, String> {
    within(text, Look::SPHERICAL)
}

fn parse_colour(text: &str) -> Result<f64, String> {
    within(text, Look::COLOUR)
}

fn parse_share(text: &str) -> Result<f64, String> {
    let neutral = 0.0;
    let (least, most) = (0.0, 1.0);
    within(
        text,
        LookRange {
            least,
            most,
            neutral,
        },
    )
}

fn parse_level(text: &str) -> Result<f64, String> {
    let level = text.trim().parse().ok();
    let level = level.filter(|level: &f64| level.is_finite() && *level >= 0.0);
    level.ok_or_else(|| "give a scene-linear value of at least 0, such as 1".to_owned())
}

fn parse_radius(text: &str) -> Result<f64, String> {
    let (least, most) = Bloom::RADII;
    let percent = text.trim().parse().ok();
    let in_range = |percent: &f64| (least..=most).contains(&(percent / 100.0));
    percent.filter(in_range).ok_or_else(|| {
        let (least, most) = (100.0 * least, 100.0 * most);
        format!("give {least} to {most} per cent of the width of the frame")
    })
}

impl LookArgs {
    /// Puts look and bloom into `settings`.
    ///
    /// # Errors
    /// A picture of the aperture that cannot be read or is black.
    pub(crate) fn put(&self, settings: &mut Settings) -> Result<(), CommandError> {
        let picture = self
            .aperture_picture
            .as_deref()
            .map(read_picture)
            .transpose()?;
        self.put_with(picture, settings);
        Ok(())
    }

    /// Puts look and bloom into `settings`, with this picture of the aperture.
    fn put_with(&self, picture: Option<AperturePicture>, settings: &mut Settings) {
        settings.look = Look {
            picture,
            blades: self.blades.map(|count| Blades {
                count,
                roundness: self.roundness,
                rotation_deg: self.rotation,
            }),
            squeeze: self.squeeze,
            obstruction: self.obstruction,
            cats_eye: self.cats_eye,
            spherical: self.spherical,
            axial_colour: self.axial_colour,
            lateral_colour: self.lateral_colour,
        };
        settings.bloom = (self.bloom > 0.0).then_some(Bloom {
            share: self.bloom,
            level: self.bloom_level,
            radius: self.bloom_radius / 100.0,
        });
    }

    /// Puts look and bloom of `frame` into `settings`, with the values that `table` has for it and the picture of `settings`.
    ///
    /// # Errors
    /// Values out of range.
    pub(super) fn put_at_frame(
        &self,
        table: &Animation,
        frame: i64,
        settings: &mut Settings,
    ) -> Result<(), FileError> {
        let mut at_frame = self.clone();
        for column in &COLUMNS {
            if let Some(value) = table.value(column.name, frame, Interpolation::Linear) {
                let parsed = (column.parse)(&value.to_string());
                *(column.option)(&mut at_frame) = parsed.map_err(|remedy| {
                    let place = format!("frame {frame}, {}", column.name);
                    FileError::new(table.path(), place, format!("is {value}"), remedy)
                })?;
            }
        }
        at_frame.put_with(settings.look.picture.take(), settings);
        Ok(())
    }

    /// Returns whether `table` changes the curvature or the rotation of blades that no option gives.
    pub(super) fn lacks_blades(&self, table: &Animation) -> bool {
        self.blades.is_none()
            && (table.names()).any(|name| name == "roundness" || name == "rotation")
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
