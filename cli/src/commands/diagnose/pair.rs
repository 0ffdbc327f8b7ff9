//! PSFs estimated from a sharp picture and the same picture through the lens.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use clap::{Args, ValueEnum};
use rayon::ThreadPool;
use seidel_core::diagnose::{PairEstimate, PairSettings, Picture, Progress, estimate_pair};
use seidel_core::distance::ObjectDistance;
use seidel_core::field::ImagePoint;
use seidel_core::predict::Predictor;
use seidel_core::profile::LensProfile;

use super::super::{CommandError, parse_distance, parse_point};
use crate::Console;
use seidel_image_io::error::FileError;
use seidel_image_io::flat_plate::Encoding;
use seidel_image_io::plate::{Plate, PlateOptions};

/// Options about a pair of pictures.
#[derive(Debug, Args)]
pub(super) struct PairArgs {
    /// Instead of OBS: a sharp picture of a flat scene full of detail (OpenEXR, PNG, TIFF, DPX, HDR or JPEG)
    #[arg(long, value_name = "SHARP", requires = "observed")]
    pub(super) reference: Option<PathBuf>,
    /// The same picture through the lens, registered pixel by pixel
    #[arg(long, value_name = "PLATE", requires = "reference")]
    pub(super) observed: Option<PathBuf>,
    /// Distance of the scene in metres, or `inf`
    #[arg(long, value_name = "Z", value_parser = parse_distance, requires = "reference")]
    depth_m: Option<ObjectDistance>,
    /// Side of the estimated tiles, px, odd: more than the widest blur
    #[arg(long, value_name = "PX", default_value_t = 33)]
    patch: usize,
    /// Where the optical axis is, in frame pixels; where the lens has it if left out
    #[arg(long, value_name = "X,Y", value_parser = parse_point, requires = "reference")]
    axis: Option<ImagePoint>,
    /// What integer samples mean; floats are linear
    #[arg(long, value_enum, default_value_t = EncodingChoice::Linear)]
    encoding: EncodingChoice,
    /// Light from which on pixels are clipped and take no part; full scale of integer samples, none of
    /// floats if left out
    #[arg(long, value_name = "LIGHT", requires = "reference")]
    clip: Option<f32>,
    /// What a pixel of the sharp picture is
    #[arg(long, value_enum, default_value_t = Pixels::Points)]
    reference_pixels: Pixels,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EncodingChoice {
    /// Proportional to light
    Linear,
    /// The sRGB transfer function
    Srgb,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Pixels {
    /// A point of light: the plate was blurred from it by a program
    Points,
    /// The mean over its area: both were photographed
    Areas,
}

/// Full scale of integer samples, less half a step of eight bits.
const FULL_SCALE: f32 = 1.0 - 0.5 / 255.0;

impl PairArgs {
    /// Estimates the PSFs between the two pictures.
    pub(super) fn estimate(
        &self,
        (sharp, plate): (&Path, &Path),
        (lens, lens_path): (&LensProfile, &Path),
        pool: &ThreadPool,
        console: &Console,
    ) -> Result<PairEstimate, CommandError> {
        let in_lens = |e| FileError::from_core(lens_path, e);
        let predictor = Predictor::new(lens).map_err(in_lens)?;
        if self.depth_m.is_none() && predictor.knows_depth() {
            return Err(FileError::new(
                plate,
                "object distance",
                "is unknown, but the lens's blur depends on it",
                "give --depth-m",
            )
            .into());
        }
        let frame = match self.axis {
            Some(axis) => lens.frame.with_axis(axis)?,
            None => lens.frame,
        };
        let names: Vec<String> = predictor.channel_names().to_vec();
        let both = [self.read(sharp, &names)?, self.read(plate, &names)?];
        let integers = both.iter().any(|p| p.integers);
        let settings = PairSettings {
            side: self.patch,
            distance: self.depth_m.unwrap_or(ObjectDistance::Unknown),
            clip: self.clip.or(integers.then_some(FULL_SCALE)),
            area_means: self.reference_pixels == Pixels::Areas,
            ..PairSettings::default()
        };
        let bar = console.progress("estimating PSFs");
        let stop = AtomicBool::new(false);
        let progress = Progress {
            report: &|share| bar.set(share),
            stop: &stop,
        };
        let [sharp, seen] = [both[0].picture(), both[1].picture()];
        let estimate = || estimate_pair(&frame, &names, &sharp, &seen, &settings, &progress);
        let mut found = pool
            .install(estimate)
            .map_err(|e| FileError::from_core(plate, e))?;
        // The camera is the lens's, as far as that is known.
        found.set.camera = lens.camera.clone();
        found.set.pixel_pitch_um = lens.pixel_pitch_um;
        Ok(found)
    }

    /// The planes of a picture by the lens's channel names.
    fn read(&self, path: &Path, names: &[String]) -> Result<Planes, CommandError> {
        let plate = self.open(path)?;
        if let Some(bad) = plate.non_finite().first() {
            return Err(FileError::new(path, "", bad.to_string(), "mend the picture").into());
        }
        let present = plate.colour_names();
        let find = |name: &String| present.iter().position(|p| p == name);
        let missing: Vec<&str> = names
            .iter()
            .filter(|name| find(name).is_none())
            .map(String::as_str)
            .collect();
        if !missing.is_empty() {
            return Err(FileError::new(
                path,
                format!("channel {}", missing.join(", ")),
                format!("is not in the picture, which has {}", present.join(", ")),
                "give a picture with the channels of the lens",
            )
            .into());
        }
        let all = plate.colour();
        Ok(Planes {
            width: plate.width(),
            height: plate.height(),
            planes: names
                .iter()
                .filter_map(find)
                .map(|k| all[k].clone())
                .collect(),
            integers: plate.holds_integers(),
        })
    }

    /// Floats are linear whatever the options say of integers.
    fn open(&self, path: &Path) -> Result<Plate, FileError> {
        let as_is = |encoding| {
            let options = PlateOptions {
                layer: None,
                encoding: Some(encoding),
                ..PlateOptions::default()
            };
            Plate::open(path, &options)
        };
        let plate = as_is(Encoding::Linear)?;
        if self.encoding == EncodingChoice::Srgb && plate.holds_integers() {
            return as_is(Encoding::Srgb);
        }
        Ok(plate)
    }
}

/// A picture as read.
struct Planes {
    width: usize,
    height: usize,
    planes: Vec<Vec<f32>>,
    integers: bool,
}

impl Planes {
    fn picture(&self) -> Picture<'_> {
        Picture {
            width: self.width,
            height: self.height,
            planes: &self.planes,
        }
    }
}
