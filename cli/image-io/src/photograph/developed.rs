//! Images that are not DNG: 16-bit mosaics in TIFF and PNG, linear images, and developments.

use std::path::Path;

use super::{PhotographFile, PhotographOptions, Precision, SensorPlane, clipping_level};
use crate::error::{FileError, Result};
use crate::formats::detect;
use crate::formats::exr;
use crate::plate::{PlateFile, PlateOptions};
use crate::raster::RasterImage;
use crate::samples::{Encoding, SampleFormat};

/// Reads an image of any format that plates may have.
pub(super) fn read(path: &Path, options: &PhotographOptions) -> Result<PhotographFile> {
    if detect(path)? == exr::FORMAT {
        return read_exr(path, options);
    }
    let image = RasterImage::open(path)?;
    let format = image.sample_format();
    let is_grey = image.names() == ["Y"];
    if is_grey && format == SampleFormat::U16 {
        let [plane] = <[Vec<f32>; 1]>::try_from(image.planes).unwrap_or_default();
        let plane = SensorPlane {
            width: image.width,
            height: image.height,
            samples: plane.iter().map(|v| (v * 65535.0).round()).collect(),
            full_scale: 65535.0,
        };
        return plane.into_photograph(path, options);
    }
    if let Some(super::ColourFilter::Mosaic(mosaic)) = options.cfa {
        return Err(FileError::new(
            path,
            "",
            format!(
                "is no {mosaic} mosaic: it has {} {format} samples a pixel",
                image.names().len()
            ),
            "give the raw photograph, or leave --cfa out",
        ));
    }
    let mut warnings = Vec::new();
    let is_float = matches!(format, SampleFormat::F16 | SampleFormat::F32);
    let (encoding, precision) = match (options.encoding, format) {
        (None, _) if is_float => (Encoding::Linear, Precision::Linear),
        (Some(Encoding::Linear), _) if format != SampleFormat::U8 => {
            (Encoding::Linear, Precision::Linear)
        }
        (Some(encoding), SampleFormat::U8) => (encoding, Precision::EightBit),
        (None, SampleFormat::U8) => {
            warnings.push(format!(
                "{}: its transfer function is not stated and taken as sRGB; give --encoding if it is not",
                path.display()
            ));
            (Encoding::Srgb, Precision::EightBit)
        }
        (Some(encoding), _) => (encoding, Precision::Developed),
        (None, _) => {
            return Err(FileError::new(
                path,
                "",
                format!("has {format} samples, which may be linear or not"),
                "give --encoding linear, srgb or the log curve of the camera; or better the raw photograph",
            ));
        }
    };
    if precision != Precision::Linear {
        warnings.push(format!(
            "{}: is a development with {format} samples. Interpolated colours, tone curve and sharpening change the PSF, so errors are stated larger; give the raw photograph",
            path.display()
        ));
    }
    let full = f32::from(format.full_scale().unwrap_or(1));
    let (black, white) = (options.black.unwrap_or(0.0), options.white);
    let count = image.planes.len() - usize::from(image.names.last().is_some_and(|n| n == "A"));
    let planes = image.planes.iter().take(count).map(|plane| {
        let samples = plane.iter();
        samples
            .map(|v| encoding.decode(*v) * full - black)
            .collect()
    });
    let white = match (white, is_float) {
        (Some(white), _) => clipping_level(black, white),
        (None, true) => f32::INFINITY,
        // Tone curves approach white; nothing near it is linear.
        (None, false) if precision != Precision::Linear => encoding.decode(0.97) * full - black,
        (None, false) => clipping_level(black, full),
    };
    Ok(PhotographFile {
        width: image.width,
        height: image.height,
        planes: planes.collect(),
        channels: image.names[..count].to_vec(),
        mosaic: None,
        white,
        gain: None,
        code_scale: Some(full),
        precision,
        warnings,
    })
}

fn read_exr(path: &Path, options: &PhotographOptions) -> Result<PhotographFile> {
    let plate = PlateFile::open(path, &PlateOptions::default())?;
    let black = options.black.unwrap_or(0.0);
    let planes = plate.colour().into_iter();
    let minus_black = |plane: Vec<f32>| plane.iter().map(|v| v - black).collect();
    let (width, height) = (plate.width(), plate.height());
    Ok(PhotographFile {
        width,
        height,
        planes: planes.map(minus_black).collect(),
        channels: plate.colour_names().to_vec(),
        mosaic: None,
        white: options.white.map_or(f32::INFINITY, |white| white - black),
        gain: None,
        code_scale: Some(1.0),
        precision: Precision::Linear,
        warnings: Vec::new(),
    })
}
