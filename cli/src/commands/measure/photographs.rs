//! Reading photographs with their dark and flat frames.

use std::path::{Path, PathBuf};

use seidel_core::distance::ObjectDistance;
use seidel_image_io::error::FileError;
use seidel_image_io::photograph::{self, PhotographFile, PhotographOptions, Precision};
use seidel_measure::{Calibration, Photograph, SampleErrors};

use super::common::CommonArgs;
use crate::Console;
use crate::commands::{CommandError, short_name};

/// Errors of developments beyond their noise. Rough upper estimates: interpolation of the missing colours of a mosaic adds up
/// to 0.5 px² of variance to edges.
const DEVELOPED_ERROR: SampleErrors = SampleErrors {
    relative: 0.05,
    centroid_px: 0.10,
    variance_px2: 0.4,
    quantum: 1.0,
};
const EIGHT_BIT_ERROR: SampleErrors = SampleErrors {
    relative: 0.08,
    centroid_px: 0.15,
    variance_px2: 0.5,
    quantum: 1.0,
};

/// Reads all photographs of the command line.
pub(super) fn read_all(
    args: &CommonArgs,
    console: &mut Console,
) -> Result<(Vec<Photograph>, Calibration), CommandError> {
    let options = args.photograph_options();
    let mut photographs = Vec::new();
    for (index, path) in args.photographs.iter().enumerate() {
        let photograph = read_one(path, &options, args.distance(index), console)?;
        photographs.push(restricted(photograph, path, &args.channels)?);
    }
    let mut frames = |paths: &[PathBuf]| -> Result<Vec<Photograph>, CommandError> {
        let one = |path: &PathBuf| {
            let photograph = read_one(path, &options, ObjectDistance::Unknown, console)?;
            restricted(photograph, path, &args.channels)
        };
        paths.iter().map(one).collect()
    };
    let (darks, flats) = (frames(&args.dark)?, frames(&args.flat)?);
    Ok((photographs, Calibration::new(&darks, &flats)?))
}

fn read_one(
    path: &Path,
    options: &PhotographOptions,
    distance: ObjectDistance,
    console: &mut Console,
) -> Result<Photograph, CommandError> {
    let file = photograph::read(path, options)?;
    for warning in &file.warnings {
        console.note(warning);
    }
    let errors = errors_of(&file);
    Ok(Photograph {
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
    })
}

fn errors_of(file: &PhotographFile) -> SampleErrors {
    match file.precision {
        Precision::Linear => SampleErrors {
            quantum: f64::from(u8::from(file.white.is_finite())),
            ..SampleErrors::default()
        },
        Precision::Developed => DEVELOPED_ERROR,
        Precision::EightBit => EIGHT_BIT_ERROR,
    }
}

/// Returns the photograph with only the channels called `names`, or all for none.
fn restricted(
    mut photograph: Photograph,
    path: &Path,
    names: &[String],
) -> Result<Photograph, CommandError> {
    if names.is_empty() {
        return Ok(photograph);
    }
    let missing = names
        .iter()
        .find(|name| !photograph.channels.contains(name));
    if let Some(name) = missing {
        return Err(CommandError::File(FileError::new(
            path,
            format!("channel {name}"),
            "is not in the photograph",
            format!("choose among {}", photograph.channels.join(", ")),
        )));
    }
    if photograph.mosaic.is_none() {
        let index = |name: &String| photograph.channels.iter().position(|c| c == name);
        let indices: Vec<usize> = names.iter().filter_map(index).collect();
        let planes = indices
            .iter()
            .map(|k| std::mem::take(&mut photograph.planes[*k]));
        photograph.planes = planes.collect();
    }
    photograph.channels = names.to_vec();
    Ok(photograph)
}
