//! PSFs estimated from a registered pair: a sharp picture and the same picture through the lens.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use rayon::ThreadPool;
use seidel_core::diagnosis::{PairGeometry, PairImage, PairSettings, Quantisation, StoredCurve};
use seidel_core::{
    DepthConvention, DiagnosisSettings, ImagePoint, Lens, ObjectDistance, PictureDiagnosis,
    PicturePair, Predictor, diagnose_pictures,
};

use super::super::picture::check_finite;
use super::super::plates::channel_parser;
use super::super::{CommandError, EncodingChoice, parse_point};
use crate::Console;
use seidel_image_io::error::FileError;
use seidel_image_io::formats::exr::DepthOwner;
use seidel_image_io::image_channel::{ChannelSpec, ImageChannel};
use seidel_image_io::plate::{PlateFile, PlateOptions};
use seidel_image_io::samples::Encoding;

/// Options of a picture pair.
#[derive(Debug, Args)]
#[command(next_help_heading = "Picture pair")]
pub(super) struct PairArgs {
    /// Sharp picture of a flat scene with fine texture, instead of OBS (OpenEXR, PNG, TIFF, DPX, HDR or JPEG)
    #[arg(long, value_name = "SHARP", requires = "observed")]
    pub(super) reference: Option<PathBuf>,
    /// Picture of the same scene through the lens, registered pixel by pixel
    #[arg(long, value_name = "PLATE", requires = "reference")]
    pub(super) observed: Option<PathBuf>,
    /// Depth pass of SHARP, in metres along the optical axis, in place of --distance: windows at nearly one distance are compared there,
    /// others are left out
    #[arg(long, value_name = "FILE[:CHANNEL]", requires = "reference", conflicts_with = "distances", value_parser = channel_parser())]
    depth: Option<ChannelSpec>,
    /// Side of the estimated tiles, px: odd, and larger than the widest blur
    #[arg(long, value_name = "PX", default_value_t = 33)]
    patch: usize,
    /// Position of the optical axis in frame pixels; that of the lens if omitted
    #[arg(long, value_name = "X,Y", value_parser = parse_point, requires = "reference")]
    axis: Option<ImagePoint>,
    /// Encoding of integer samples; floats are scene-linear. If omitted: sRGB, except in DPX, where the header decides
    #[arg(long, value_enum)]
    pub(super) encoding: Option<EncodingChoice>,
    /// Level from which pixels are treated as clipped and ignored; if omitted, full scale for integer samples and none for
    /// floats
    #[arg(long, value_name = "LIGHT", requires = "reference")]
    clip: Option<f32>,
    /// Meaning of a pixel of the sharp picture
    #[arg(long, value_enum, default_value_t = Pixels::Points)]
    reference_pixels: Pixels,
    /// Displacement of light in the plate; measured if omitted
    #[arg(long, value_enum, requires = "reference")]
    plate_geometry: Option<Geometry>,
    /// Write pictures of where PLATE and a rendering of SHARP differ, with LENS and with the corrected lens: plate-gap.exr and
    /// plate-gap.png. They show the mean squared difference over the local variance of PLATE
    #[arg(long, requires = "reference")]
    pub(super) plate_gap: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Geometry {
    /// Channels are displaced against each other only, as `seidel apply` renders by default
    Undistorted,
    /// The plate is distorted by the lens, as a photograph is
    Distorted,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Pixels {
    /// A point sample: the plate was blurred from it by a program
    Points,
    /// The mean over the pixel's area: both pictures are photographs
    Areas,
}

/// Clip level of integer samples: full scale less half a step of eight bits.
const FULL_SCALE: f32 = 1.0 - 0.5 / 255.0;

impl PairArgs {
    /// Diagnoses `lens` against the PSFs that take `sharp` to `blurred`.
    #[expect(clippy::too_many_arguments, reason = "files and their contents")]
    pub(super) fn diagnose(
        &self,
        sharp: &Path,
        blurred: &Path,
        lens: &Lens,
        lens_path: &Path,
        distance: ObjectDistance,
        settings: &DiagnosisSettings,
        pool: &ThreadPool,
        console: &Console,
    ) -> Result<PictureDiagnosis, CommandError> {
        let predictor =
            Predictor::new(lens.profile()).map_err(|e| FileError::from_core(lens_path, e))?;
        let is_known = distance != ObjectDistance::Unknown || self.depth.is_some();
        if !is_known && predictor.depends_on_depth() {
            return Err(FileError::new(
                blurred,
                "object distance",
                "is unknown, but the lens's blur depends on it",
                "give --distance, or a depth pass with --depth",
            )
            .into());
        }
        let channels = predictor.channel_names();
        let (reference, observed) = (self.read(sharp, channels)?, self.read(blurred, channels)?);
        let integers = reference.quantisation.is_some() || observed.quantisation.is_some();
        let estimate = PairSettings {
            side: self.patch,
            distance,
            vergence: self.read_vergence(&reference)?,
            clip: self.clip.or(integers.then_some(FULL_SCALE)),
            area_means: self.reference_pixels == Pixels::Areas,
            geometry: match self.plate_geometry {
                None => PairGeometry::Measured,
                Some(Geometry::Undistorted) => PairGeometry::Undistorted,
                Some(Geometry::Distorted) => PairGeometry::Distorted,
            },
            ..PairSettings::default()
        };
        let pair = PicturePair {
            reference: reference.picture(),
            observed: observed.picture(),
            axis: self.axis,
            estimate,
        };
        let bar = console.progress_bar("estimating PSFs and diagnosing");
        let progress = |share| bar.show(share);
        let diagnose = || diagnose_pictures(lens, &pair, settings, &progress);
        let found = pool.install(diagnose);
        Ok(found.map_err(|e| FileError::from_core(blurred, e))?)
    }

    /// Reads the depth pass of the sharp picture as vergences, 1/m; `None` without one.
    fn read_vergence(&self, sharp: &Planes) -> Result<Option<Vec<f32>>, CommandError> {
        let Some(spec) = &self.depth else {
            return Ok(None);
        };
        let pass =
            ImageChannel::read_depth(&spec.file, spec.channel.as_deref(), DepthOwner::Unknown)?;
        let place = format!("channel {}", pass.channel);
        if pass.samples.len() != sharp.width * sharp.height {
            return Err(FileError::new(
                &spec.file,
                place,
                format!(
                    "is not of the {} x {} px of the sharp picture",
                    sharp.width, sharp.height
                ),
                "render the depth pass with the sharp picture",
            )
            .into());
        }
        let metres = DepthConvention::Distance {
            metres_per_unit: 1.0,
        };
        let reading = metres.read(&pass.samples, sharp.width);
        let reading = reading.map_err(|e| FileError::from_core(&spec.file, e.within(&place)))?;
        Ok(Some(reading.vergence))
    }

    /// Reads the planes of a picture in the order of the lens's `channels`.
    fn read(&self, path: &Path, channels: &[String]) -> Result<Planes, CommandError> {
        let plate = self.open(path)?;
        check_finite(&plate)?;
        let present = plate.colour_names();
        let find = |name: &String| present.iter().position(|p| p == name);
        let missing: Vec<&str> = channels
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
        let planes = channels.iter().filter_map(find).map(|k| all[k].clone());
        Ok(Planes {
            width: plate.width(),
            height: plate.height(),
            planes: planes.collect(),
            quantisation: quantisation(&plate),
        })
    }

    /// Opens a picture; `--encoding` applies to integer samples only.
    fn open(&self, path: &Path) -> Result<PlateFile, FileError> {
        let open = |encoding| {
            let options = PlateOptions {
                layer: None,
                encoding,
                ..PlateOptions::default()
            };
            PlateFile::open(path, &options)
        };
        let plate = open(None)?;
        match self.encoding {
            Some(encoding) if plate.has_integer_samples() => open(Some(encoding.into())),
            _ => Ok(plate),
        }
    }
}

/// Returns the rounding of the samples of `plate`, if they are integers.
fn quantisation(plate: &PlateFile) -> Option<Quantisation> {
    let full_scale = plate.integer_full_scale()?;
    Some(Quantisation {
        step: 1.0 / f64::from(full_scale),
        curve: match plate.encoding() {
            Some(Encoding::Linear) | None => StoredCurve::Linear,
            // The others are steep in the shadows as sRGB is.
            Some(_) => StoredCurve::Srgb,
        },
    })
}

/// The colour planes of a picture.
struct Planes {
    width: usize,
    height: usize,
    planes: Vec<Vec<f32>>,
    /// Rounding of the samples, if the file stores integers.
    quantisation: Option<Quantisation>,
}

impl Planes {
    fn picture(&self) -> PairImage<'_> {
        PairImage {
            width: self.width,
            height: self.height,
            planes: &self.planes,
            quantisation: self.quantisation,
        }
    }
}
