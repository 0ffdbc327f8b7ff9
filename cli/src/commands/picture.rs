//! Pictures read for fits, evaluations and diagnoses.

use std::path::Path;

use seidel_calibrate::score::TestImage;

use super::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::plate::{PlateFile, PlateOptions};

/// Rejects a picture with samples that are not finite.
pub(super) fn check_finite(plate: &PlateFile) -> Result<(), FileError> {
    plate.non_finite().first().map_or(Ok(()), |bad| {
        let remedy = "correct the picture";
        Err(FileError::new(plate.path(), "", bad.to_string(), remedy))
    })
}

/// Reads the luminance of a picture, by Rec. 709 weights if it is in colour.
pub(super) fn read_image(path: &Path) -> Result<TestImage, CommandError> {
    let plate = PlateFile::open(path, &PlateOptions::default())?;
    check_finite(&plate)?;
    let planes = plate.colour();
    let weights: &[f64] = if planes.len() == 3 {
        &[0.2126, 0.7152, 0.0722]
    } else {
        &[1.0]
    };
    let samples = (0..plate.width() * plate.height())
        .map(|i| {
            let weighted = planes.iter().zip(weights);
            weighted.map(|(plane, w)| w * f64::from(plane[i])).sum()
        })
        .collect();
    Ok(TestImage::new(plate.width(), plate.height(), samples)
        .map_err(|e| FileError::from_core(path, e))?)
}
