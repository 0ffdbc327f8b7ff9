//! Reading photographs with their dark and flat frames.

use std::path::{Path, PathBuf};

use seidel_core::ObjectDistance;
use seidel_image_io::error::FileError;
use seidel_image_io::photograph::{self, PhotographFile, PhotographOptions, Precision};
use seidel_measure::{Calibration, Photograph, SampleErrors};

use super::common::InputArgs;
use crate::Console;
use crate::commands::{CommandError, short_name};

/// Reads the photographs of the command line at `paths`, and says what they state about the camera.
pub(super) fn read_all(
    paths: &[PathBuf],
    args: &InputArgs,
    console: &mut Console,
) -> Result<(Vec<Photograph>, Calibration), CommandError> {
    let (photographs, calibration) = read_samples(paths, args, console)?;
    if let (Some(path), Some(first)) = (paths.first(), photographs.first()) {
        let data = args.camera.of(paths, first.width)?;
        if let Some(remark) = args.camera.remark(path, &data) {
            console.note(remark);
        }
    }
    Ok((photographs, calibration))
}

/// Reads the photographs at `paths`, with dark and flat frames.
pub(in crate::commands) fn read_samples(
    paths: &[PathBuf],
    args: &InputArgs,
    console: &mut Console,
) -> Result<(Vec<Photograph>, Calibration), CommandError> {
    let options = args.photograph_options();
    let mut photographs = Vec::new();
    for (index, path) in paths.iter().enumerate() {
        let distance = args.distance(index);
        photographs.push(read_one(path, &options, distance, args, console)?);
    }
    let mut frames = |paths: &[PathBuf]| -> Result<Vec<Photograph>, CommandError> {
        let one = |path: &PathBuf| read_one(path, &options, ObjectDistance::Unknown, args, console);
        paths.iter().map(one).collect()
    };
    let (darks, flats) = (frames(&args.sensor.dark)?, frames(&args.sensor.flat)?);
    Ok((photographs, Calibration::new(&darks, &flats)?))
}

fn read_one(
    path: &Path,
    options: &PhotographOptions,
    distance: ObjectDistance,
    args: &InputArgs,
    console: &mut Console,
) -> Result<Photograph, CommandError> {
    let mut file = photograph::read(path, options)?;
    if let Some(encoding) = args.encoding {
        encoding.decode_log(path, &mut file)?;
    }
    for warning in &file.warnings {
        console.note(warning);
    }
    let errors = errors_of(&file);
    let photograph = Photograph {
        name: short_name(path),
        width: file.width,
        height: file.height,
        planes: file.planes,
        channels: file.channels,
        mosaic: file.mosaic,
        white: file.white,
        distance,
        gain: file.gain,
        errors,
        bad: Vec::new(),
    };
    let restricted = photograph.restricted_to(&args.channels);
    Ok(restricted.map_err(|error| FileError::from_core(path, error))?)
}

fn errors_of(file: &PhotographFile) -> SampleErrors {
    match file.precision {
        Precision::Linear if file.white.is_finite() => SampleErrors::COUNTS,
        Precision::Linear => SampleErrors::default(),
        Precision::Developed => SampleErrors::DEVELOPED,
        Precision::EightBit => SampleErrors::EIGHT_BIT,
    }
}
