//! Residual files of `remove`: the sharp image, and the difference between the plate and the blurred sharp image.
//!
//! Blurring the sharp image again and adding the residual restores the plate.

use std::path::{Path, PathBuf};

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::*;

use crate::error::{FileError, Result};
use crate::formats::exr::{Compressing, ExrImage, bounds, new_text, window, write_exr};
use crate::metadata::TextAttributes;
use crate::windows::ImageWindows;
use seidel_optics::Rectangle;

// Attributes of the file.
const PLATE_WINDOW: &str = "plateDataWindow";
const SETTINGS: &str = "seidelSettings";
const NOISE: &str = "seidelNoise";

/// A residual in memory. Planes are scene-linear, row-major over the data window of the sharp image.
#[derive(Debug, Clone)]
pub struct Residual {
    /// The path of the file that it was read from, or is written to.
    pub path: PathBuf,
    /// The windows of the sharp image.
    pub windows: ImageWindows,
    /// The data window of the plate.
    pub plate: Rectangle,
    /// Names of the planes, such as R or A.
    pub names: Vec<String>,
    /// The sharp image as it was stored.
    pub sharp: Vec<Vec<f32>>,
    /// The plate minus the blurred sharp image; zero beyond the plate.
    pub residual: Vec<Vec<f32>>,
    /// Standard deviation of the noise of each plane.
    pub noise: Vec<f64>,
    /// The settings of the render, each with its name.
    pub settings: TextAttributes,
}

impl Residual {
    /// Writes the residual as an EXR file with float channels `sharp.NAME` and `residual.NAME`, whole or not at all.
    ///
    /// # Errors
    /// A target that cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let named = |layer: &str, planes: &[Vec<f32>]| -> Vec<AnyChannel<FlatSamples>> {
            let pairs = self.names.iter().zip(planes);
            let channel = |(name, plane): (&String, &Vec<f32>)| {
                let name = format!("{layer}.{name}");
                AnyChannel::new(name.as_str(), FlatSamples::F32(plane.clone()))
            };
            pairs.map(channel).collect()
        };
        let mut list = named("sharp", &self.sharp);
        list.extend(named("residual", &self.residual));
        let ImageWindows { data, display } = self.windows;
        let mut attributes = LayerAttributes {
            layer_position: Vec2(data.x, data.y),
            ..LayerAttributes::default()
        };
        let noise: Vec<String> = self.noise.iter().map(f64::to_string).collect();
        let settings = self
            .settings
            .iter()
            .map(|(name, value)| format!("{name}: {value}"));
        let texts = [
            (NOISE, noise.join(" ")),
            (SETTINGS, settings.collect::<Vec<_>>().join("\n")),
        ];
        for (name, text) in texts {
            let text = AttributeValue::Text(new_text(&text));
            attributes.other.insert(Text::from(name), text);
        }
        let plate = AttributeValue::IntegerBounds(bounds(self.plate));
        attributes.other.insert(Text::from(PLATE_WINDOW), plate);
        let layer = Layer::new(
            (data.width, data.height),
            attributes,
            Encoding::SMALL_LOSSLESS,
            AnyChannels::sort(list.into()),
        );
        let mut image = Image::from_layer(layer);
        image.attributes.display_window = bounds(display);
        write_exr(path, &image, Compressing::Parallel)
    }

    /// Reads the residual of a plate with planes called `names`.
    ///
    /// # Errors
    /// A file that cannot be read, is not a residual, or has other planes.
    pub fn open(path: &Path, names: &[String]) -> Result<Self> {
        let file = ExrImage::open(path)?;
        let missing = |field: &str| {
            FileError::new(
                path,
                field,
                "is missing: the file is not a residual of this plate",
                "give the file that seidel remove --residual wrote with the plate",
            )
        };
        let channels = file.channels();
        let planes = |layer: &str| -> Result<Vec<Vec<f32>>> {
            let plane = |name: &String| {
                let wanted = format!("{layer}.{name}");
                let found = channels.iter().find(|c| c.name == wanted);
                let found = found.ok_or_else(|| missing(&format!("channel {wanted}")))?;
                Ok(file.samples(found.id))
            };
            names.iter().map(plane).collect()
        };
        let (sharp, residual) = (planes("sharp")?, planes("residual")?);
        let Some(AttributeValue::IntegerBounds(plate)) = file.attribute(0, PLATE_WINDOW) else {
            return Err(missing(PLATE_WINDOW));
        };
        let text = |name: &str| file.text(0, name).ok_or_else(|| missing(name));
        let noise: Vec<f64> = (text(NOISE)?.split_whitespace())
            .filter_map(|word| word.parse().ok().filter(|v: &f64| *v >= 0.0))
            .collect();
        if noise.len() != names.len() {
            return Err(missing(NOISE));
        }
        let setting = |line: &str| {
            let (name, value) = line.split_once(": ")?;
            Some((name.to_owned(), value.to_owned()))
        };
        let residual = Self {
            path: path.to_owned(),
            windows: file.windows(channels[0].id),
            plate: window(*plate),
            names: names.to_vec(),
            sharp,
            residual,
            noise,
            settings: text(SETTINGS)?.lines().filter_map(setting).collect(),
        };
        residual.check()?;
        Ok(residual)
    }

    /// Refuses samples that are not finite, and a plate that is not within the sharp image.
    fn check(&self) -> Result<()> {
        let planes = self.sharp.iter().chain(&self.residual);
        if planes.flatten().any(|v| !v.is_finite()) {
            return Err(FileError::new(
                &self.path,
                "channels",
                "hold NaN or infinite samples",
                "run seidel remove --residual again",
            ));
        }
        if self.windows.data.encloses(self.plate) {
            return Ok(());
        }
        Err(FileError::new(
            &self.path,
            PLATE_WINDOW,
            format!("is {}, the data window {}", self.plate, self.windows.data),
            "run seidel remove --residual again",
        ))
    }
}
