//! PSFs measured in photographs of lights, for a diagnosis in one go.

use std::path::{Path, PathBuf};

use clap::Args;
use seidel_core::{LensProfile, ObjectDistance, ObservationSet, Predictor};
use seidel_image_io::error::FileError;
use seidel_measure::{LightSettings, measure_lights};

use super::super::measure::camera::CameraArgs;
use super::super::measure::common::{InputArgs, SensorArgs};
use super::super::measure::encoding::PhotographEncoding;
use super::super::measure::photographs;
use super::super::{CommandError, EncodingChoice};
use crate::Console;
use crate::progress::ProgressArgs;

/// Options of photographs of lights.
#[derive(Debug, Args)]
#[command(next_help_heading = "Photographs of lights")]
pub(super) struct PhotoArgs {
    /// Photographs of point lights through the lens, instead of OBS: raw as for `measure lights`; writes their PSFs to psf
    #[arg(long, value_name = "PHOTO", num_args = 1.., conflicts_with_all = ["observations", "reference"])]
    pub(super) photo: Vec<PathBuf>,
    #[command(flatten)]
    sensor: SensorArgs,
}

/// A measured set with remarks on the measurement.
pub(super) struct MeasuredPhotographs {
    pub(super) set: ObservationSet,
    pub(super) remarks: Vec<String>,
}

impl PhotoArgs {
    /// Measures the lights of the photographs, at one of the `distances` each or one for all, in the channels of `lens`.
    ///
    /// # Errors
    /// Unknown distances where the blur of the lens depends on them; photographs that cannot be measured, or that lack a channel
    /// of the lens.
    pub(super) fn measure(
        &self,
        lens: &LensProfile,
        lens_path: &Path,
        distances: &[ObjectDistance],
        encoding: Option<EncodingChoice>,
        console: &mut Console,
    ) -> Result<MeasuredPhotographs, CommandError> {
        let (photographs, count) = (self.photo.len(), distances.len());
        if count > 1 && count != photographs {
            return Err(CommandError::Usage(format!(
                "--distance gives {count} distances for {photographs} photographs; give one for each, or one for all"
            )));
        }
        let first = &self.photo[0];
        let predictor = Predictor::new(lens).map_err(|e| FileError::from_core(lens_path, e))?;
        if distances.is_empty() && predictor.depends_on_depth() {
            return Err(FileError::new(
                first,
                "object distance",
                "is unknown, but the lens's blur depends on it",
                "give --distance",
            )
            .into());
        }
        let input = InputArgs {
            progress: ProgressArgs::default(),
            distances: distances.to_vec(),
            channels: predictor.channel_names().to_vec(),
            sensor: self.sensor.clone(),
            encoding: encoding.map(PhotographEncoding::Plain),
            camera: CameraArgs::default(),
        };
        let (photographs, calibration) = photographs::read_samples(&self.photo, &input, console)?;
        let assumed_gain = photographs[0].assumed_gain();
        let measured = measure_lights(photographs, &calibration, &LightSettings::default())
            .map_err(|e| FileError::from_core(first, e))?;
        if let Some(refusal) = measured.refusal() {
            return Err(refusal.clone().into());
        }
        let mut set = measured.observations(Some(lens.frame.axis()))?;
        let mut remarks = vec![format!(
            "{} lights were measured, {} were left out: `seidel measure lights` says why",
            set.observations.len(),
            measured.left_out.len()
        )];
        if set.observations.iter().any(|o| o.gain.is_none()) && assumed_gain > 0.0 {
            for observation in &mut set.observations {
                observation.gain = observation.gain.or(Some(assumed_gain));
            }
            remarks.push(format!(
                "the files state no gain: {assumed_gain:.2} counts per electron were assumed, those of a sensor of 30,000 electrons"
            ));
        }
        remarks.extend(measured.warnings);
        Ok(MeasuredPhotographs { set, remarks })
    }
}
