//! Options that all kinds of photographs share.

use std::path::PathBuf;

use crate::progress::ProgressArgs;
use clap::Args;
use seidel_core::{AxisChoice, Mosaic, ObjectDistance, ObservationSet};
use seidel_image_io::photograph::{ColourFilter, PhotographOptions};

use super::camera::{CameraArgs, CameraData};
use super::encoding::{self, PhotographEncoding};
use crate::commands::fit::parse_axis;
use crate::commands::{CommandError, parse_distance};

/// Options about the sensor: its calibration, mosaic and levels.
#[derive(Debug, Clone, Args)]
pub(in crate::commands) struct SensorArgs {
    /// Dark frames: photographs with the cap on, at the same exposure
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub(in crate::commands) dark: Vec<PathBuf>,
    /// Flat frames: photographs of an evenly lit surface
    #[arg(long, value_name = "FILE", num_args = 1..)]
    pub(in crate::commands) flat: Vec<PathBuf>,
    /// Colours of the mosaic's top-left 2 x 2 pixels, such as RGGB, or `none`; from the file if omitted
    #[arg(long, value_name = "RGGB|none", value_parser = parse_colour_filter)]
    cfa: Option<ColourFilter>,
    /// Black level in counts, or `auto` for that of the file
    #[arg(long, value_name = "N|auto", value_parser = parse_level)]
    black: Option<Level>,
    /// Level in counts at which samples clip, or `auto` for that of the file
    #[arg(long, value_name = "N|auto", value_parser = parse_level)]
    white: Option<Level>,
}

/// Options about the photographs themselves.
#[derive(Debug, Args)]
pub(in crate::commands) struct InputArgs {
    #[command(flatten)]
    pub(in crate::commands) progress: ProgressArgs,
    /// Distance of the scene in metres from the entrance pupil, or `inf`: one for each photograph, or one for all
    #[arg(long = "distance", alias = "distance-m", value_name = "METRES", value_delimiter = ',', value_parser = parse_distance)]
    pub(in crate::commands) distances: Vec<ObjectDistance>,
    /// Channels to measure, all if omitted
    #[arg(long, value_name = "R,G,B", value_delimiter = ',')]
    pub(in crate::commands) channels: Vec<String>,
    #[command(flatten)]
    pub(in crate::commands) sensor: SensorArgs,
    /// Transfer function of images that are not raw: linear, srgb, or the log curve of a camera
    #[arg(long, value_name = "CURVE", value_parser = encoding::parser())]
    pub(in crate::commands) encoding: Option<PhotographEncoding>,
    #[command(flatten)]
    pub(in crate::commands) camera: CameraArgs,
}

/// Options about photographs, the set that is written, and the fit.
#[derive(Debug, Args)]
pub(super) struct CommonArgs {
    /// Photographs of one camera and lens at one setting: DNG, 16-bit TIFF, PNG or PGM mosaics, FITS, linear OpenEXR or TIFF
    #[arg(required = true, value_name = "PHOTO")]
    pub(super) photographs: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) input: InputArgs,
    /// Folder to write the observation set to
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Position of the optical axis: X,Y in frame pixels, or `free` to estimate it with --fit (the default there)
    #[arg(long, value_name = "free|X,Y", value_parser = parse_axis)]
    pub(super) axis: Option<AxisChoice>,
    /// Also fit a lens to the set and write it
    #[arg(long, value_name = "LENS")]
    pub(super) fit: Option<PathBuf>,
    /// Observation set whose observations to add: other distances, other photographs
    #[arg(long, value_name = "OBS")]
    pub(super) also: Option<PathBuf>,
    /// Draw what was measured over the frame into this file too
    #[arg(long, value_name = "FILE.png")]
    pub(super) sheet: Option<PathBuf>,
    /// Write the report as a web page to this file too
    #[arg(long, value_name = "FILE.html")]
    pub(super) report: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// A level of the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::commands) enum Level {
    Auto,
    Counts(f32),
}

fn parse_level(text: &str) -> Result<Level, String> {
    if text == "auto" {
        return Ok(Level::Auto);
    }
    let counts = text.parse().ok().filter(|v: &f32| v.is_finite());
    counts
        .map(Level::Counts)
        .ok_or_else(|| "give counts, or `auto`".to_owned())
}

fn parse_colour_filter(text: &str) -> Result<ColourFilter, String> {
    if text.eq_ignore_ascii_case("none") {
        return Ok(ColourFilter::None);
    }
    let mosaic = Mosaic::parse(&text.to_ascii_uppercase());
    mosaic
        .map(ColourFilter::Mosaic)
        .map_err(|error| format!("{}, or `none`", error.remedy))
}

impl CommonArgs {
    /// Checks the options that do not go together, where a lens is fitted with --fit only.
    pub(super) fn check(&self) -> Result<(), CommandError> {
        self.check_photographs()?;
        if self.axis == Some(AxisChoice::Free) && self.fit.is_none() {
            return Err(CommandError::Usage(
                "--axis free estimates the axis by the fit of a lens; add --fit LENS, or give X,Y"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    /// Returns the camera of the photographs, of `width` pixels, as options and files state it.
    pub(super) fn camera(&self, width: u32) -> Result<CameraData, CommandError> {
        self.input.camera.of(&self.photographs, width as usize)
    }

    /// Puts the camera of the photographs into `set`, which keeps what they do not state.
    pub(super) fn put_camera(&self, set: &mut ObservationSet) -> Result<(), CommandError> {
        let data = self.camera(set.frame.width_px())?;
        data.fill(&mut set.camera, &mut set.pixel_pitch_um);
        Ok(())
    }

    /// Checks that there is one distance for each photograph, or one for all.
    pub(super) fn check_photographs(&self) -> Result<(), CommandError> {
        let (photographs, distances) = (self.photographs.len(), self.input.distances.len());
        if distances > 1 && distances != photographs {
            return Err(CommandError::Usage(format!(
                "--distance gives {distances} distances for {photographs} photographs; give one for each, or one for all"
            )));
        }
        Ok(())
    }
}

impl InputArgs {
    /// Returns the distance of photograph `index`.
    pub(super) fn distance(&self, index: usize) -> ObjectDistance {
        let given = self.distances.get(index).or(self.distances.first());
        given.copied().unwrap_or(ObjectDistance::Unknown)
    }

    /// Returns what the user states about the photographs.
    pub(super) fn photograph_options(&self) -> PhotographOptions {
        let counts = |level: Option<Level>| match level {
            Some(Level::Counts(counts)) => Some(counts),
            Some(Level::Auto) | None => None,
        };
        PhotographOptions {
            cfa: self.sensor.cfa,
            black: counts(self.sensor.black),
            white: counts(self.sensor.white),
            encoding: self.encoding.map(PhotographEncoding::of_codes),
        }
    }
}
