//! Photographs of a call: files, or arrays of counts.

use std::path::PathBuf;

use pyo3::prelude::*;
use seidel_core::{Mosaic, ObjectDistance};
use seidel_image_io::FileError;
use seidel_image_io::photograph::{
    self, ColourFilter, PhotographFile, PhotographOptions, Precision, clipping_level,
};
use seidel_image_io::samples::Encoding;
use seidel_measure::{Photograph, SampleErrors};

use crate::array::{ArrayPlanes, SampleType};
use crate::depth::object_distance;
use crate::error::{Failure, Result};

/// Properties of all photographs of a call.
pub(crate) struct PhotographArgs {
    pub(crate) options: PhotographOptions,
    pub(crate) channels: Vec<String>,
}

/// A photograph before its file is read.
pub(crate) struct PhotographSource {
    samples: Samples,
    name: String,
    distance: ObjectDistance,
}

enum Samples {
    File(PathBuf),
    Array(Box<PhotographFile>),
}

/// A photograph, and remarks on what was assumed about it.
pub(crate) struct ReadPhotograph {
    pub(crate) photograph: Photograph,
    pub(crate) warnings: Vec<String>,
}

impl PhotographArgs {
    /// Reads the arguments `cfa` and `encoding`; levels are counts.
    ///
    /// # Errors
    /// A mosaic or an encoding that there is not.
    pub(crate) fn new(
        cfa: Option<&str>,
        encoding: Option<&str>,
        levels: Levels,
        channels: Vec<String>,
    ) -> Result<Self> {
        let cfa = match cfa {
            None => None,
            Some(word) if word.eq_ignore_ascii_case("none") => Some(ColourFilter::None),
            Some(word) => Some(ColourFilter::Mosaic(Mosaic::parse(
                &word.to_ascii_uppercase(),
            )?)),
        };
        let encoding = match encoding {
            None => None,
            Some("linear") => Some(Encoding::Linear),
            Some("srgb") => Some(Encoding::Srgb),
            Some(other) => {
                return Err(Failure::argument(
                    "encoding",
                    format!("is {other:?}"),
                    "give \"linear\", \"srgb\", or None",
                ));
            }
        };
        Ok(Self {
            options: PhotographOptions {
                cfa,
                black: levels.black,
                white: levels.white,
                encoding,
            },
            channels,
        })
    }

    /// Takes the argument `name`: a photograph or a sequence of them, each a path or an array. Files are read later.
    ///
    /// # Errors
    /// Arrays of another shape or sample type, and another number of distances than of photographs.
    pub(crate) fn sources(
        &self,
        name: &str,
        photographs: &Bound<'_, PyAny>,
        distances: Option<&Bound<'_, PyAny>>,
    ) -> Result<Vec<PhotographSource>> {
        let is_single = photographs.hasattr("dtype")? || photographs.extract::<PathBuf>().is_ok();
        let all: Vec<Bound<'_, PyAny>> = if is_single {
            vec![photographs.clone()]
        } else {
            photographs.try_iter()?.collect::<PyResult<_>>()?
        };
        let distances = read_distances(distances, all.len())?;
        let all = all.iter().zip(distances).enumerate();
        all.map(|(index, (photograph, distance))| {
            if let Ok(path) = photograph.extract::<PathBuf>() {
                let file_name = path.file_name().unwrap_or(path.as_os_str());
                return Ok(PhotographSource {
                    name: file_name.to_string_lossy().into_owned(),
                    samples: Samples::File(path),
                    distance,
                });
            }
            let name = format!("{name} {index}");
            let read = self.read_array(&name, photograph)?;
            Ok(PhotographSource {
                name,
                samples: Samples::Array(Box::new(read)),
                distance,
            })
        })
        .collect()
    }

    /// Reads an array of counts: a mosaic, a monochrome image, or linear R, G and B.
    fn read_array(&self, name: &str, array: &Bound<'_, PyAny>) -> Result<PhotographFile> {
        let ArrayPlanes { layout, mut planes } = ArrayPlanes::read_counts(name, array)?;
        let PhotographOptions {
            cfa, black, white, ..
        } = self.options;
        let (mosaic, channels): (_, &[&str]) = match (planes.len(), cfa) {
            (1, Some(ColourFilter::Mosaic(mosaic))) => (Some(mosaic), &["R", "G", "B"]),
            (1, Some(ColourFilter::None)) => (None, &["Y"]),
            (3, None | Some(ColourFilter::None)) => (None, &["R", "G", "B"]),
            (1, None) => {
                return Err(Failure::argument(
                    "cfa",
                    format!("is None, but {name} has one channel"),
                    "give the top-left 2 x 2 pixels, such as \"RGGB\", or \"none\" for a monochrome sensor",
                ));
            }
            (count, _) => {
                return Err(Failure::argument(
                    name,
                    format!("has {count} channels"),
                    "give one channel with cfa, or three (linear R, G and B) without",
                ));
            }
        };
        let black = black.unwrap_or(0.0);
        let white = match (white, layout.sample()) {
            (Some(white), SampleType::Count) => clipping_level(black, white),
            (Some(white), _) => white - black,
            (None, SampleType::Count) => {
                return Err(Failure::argument(
                    "white",
                    format!("is None, but {name} has integer samples"),
                    "give the count at which the sensor clips",
                ));
            }
            (None, _) => f32::INFINITY,
        };
        for sample in planes.iter_mut().flatten() {
            *sample -= black;
        }
        Ok(PhotographFile {
            width: layout.width,
            height: layout.height,
            planes,
            channels: channels.iter().map(|name| (*name).to_owned()).collect(),
            mosaic,
            white,
            gain: None,
            code_scale: None,
            precision: Precision::Linear,
            warnings: Vec::new(),
        })
    }
}

/// Levels of the sensor, counts; `None` where the files say it.
pub(crate) struct Levels {
    pub(crate) black: Option<f32>,
    pub(crate) white: Option<f32>,
}

/// Reads the argument `distance`: one for all of `count` photographs, or one for each.
fn read_distances(
    distances: Option<&Bound<'_, PyAny>>,
    count: usize,
) -> Result<Vec<ObjectDistance>> {
    let Some(distances) = distances else {
        return Ok(vec![ObjectDistance::Unknown; count]);
    };
    if let Ok(metres) = distances.extract::<f64>() {
        return Ok(vec![ObjectDistance::metres(metres)?; count]);
    }
    let each: Vec<Option<f64>> = distances.extract()?;
    if each.len() != count {
        return Err(Failure::argument(
            "distance",
            format!("gives {} distances for {count} photographs", each.len()),
            "give one for each, or one for all",
        ));
    }
    each.into_iter().map(object_distance).collect()
}

impl PhotographSource {
    /// Reads the file, if it is one.
    ///
    /// # Errors
    /// A file that cannot be read, and a photograph without one of the channels.
    pub(crate) fn read(self, args: &PhotographArgs) -> Result<ReadPhotograph> {
        let (file, path) = match self.samples {
            Samples::File(path) => (photograph::read(&path, &args.options)?, Some(path)),
            Samples::Array(file) => (*file, None),
        };
        let errors = match file.precision {
            Precision::Linear if file.white.is_finite() => SampleErrors::COUNTS,
            Precision::Linear => SampleErrors::default(),
            Precision::Developed => SampleErrors::DEVELOPED,
            Precision::EightBit => SampleErrors::EIGHT_BIT,
        };
        let photograph = Photograph {
            name: self.name,
            width: file.width,
            height: file.height,
            planes: file.planes,
            channels: file.channels,
            mosaic: file.mosaic,
            white: file.white,
            distance: self.distance,
            gain: file.gain,
            errors,
            bad: Vec::new(),
        };
        let restricted = photograph.restricted_to(&args.channels);
        let photograph = match path {
            Some(path) => restricted.map_err(|error| FileError::from_core(&path, error))?,
            None => restricted?,
        };
        Ok(ReadPhotograph {
            photograph,
            warnings: file.warnings,
        })
    }
}
