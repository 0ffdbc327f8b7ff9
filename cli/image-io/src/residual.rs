//! What a plate has beside what its lens makes of the sharp picture, with that picture: enough to put the lens back on
//! and get the plate.

use std::path::{Path, PathBuf};

use exr::meta::attribute::{AttributeValue, IntegerBounds, Text};
use exr::prelude::*;

use crate::error::{FileError, Result};
use crate::exr::file::write_exr;
use crate::exr::plate::{ExrPlate, Window};
use crate::windows::Windows;

/// Attributes of the file.
const PLATE_WINDOW: &str = "plateDataWindow";
const SETTINGS: &str = "seidelSettings";
const NOISE: &str = "seidelNoise";

/// A residual in memory. Planes are light, row-major over the sharp picture's data window.
#[derive(Debug, Clone)]
pub struct Residual {
    /// The file it was read from.
    pub path: PathBuf,
    /// Where the sharp picture lies.
    pub windows: Windows,
    /// The data window of the plate.
    pub plate: Window,
    /// Names of the planes, such as R or A.
    pub names: Vec<String>,
    /// The sharp picture as it was stored.
    pub sharp: Vec<Vec<f32>>,
    /// The plate less the sharp picture seen through the lens; zero beyond the plate.
    pub residual: Vec<Vec<f32>>,
    /// Standard deviation of the noise of each plane.
    pub noise: Vec<f64>,
    /// How the lens was used, each setting by its name.
    pub settings: Vec<(String, String)>,
}

impl Residual {
    /// Writes the residual to `path`, whole or not at all, as float channels `sharp.NAME` and `residual.NAME`.
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
        let Windows { data, display } = self.windows;
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
            let text = AttributeValue::Text(Text::new_or_none(&text).unwrap_or_default());
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
        write_exr(path, &image, true)
    }

    /// Reads the residual of the planes called `names`.
    ///
    /// # Errors
    /// A file that cannot be read, that is no residual, or that is one of other planes.
    pub fn open(path: &Path, names: &[String]) -> Result<Self> {
        let file = ExrPlate::open(path)?;
        let none_such = |field: &str| {
            FileError::new(
                path,
                field,
                "is not in the file, which is no residual of this plate",
                "give the file that seidel remove --residual wrote with the plate",
            )
        };
        let channels = file.channels();
        let planes = |layer: &str| -> Result<Vec<Vec<f32>>> {
            let plane = |name: &String| {
                let wanted = format!("{layer}.{name}");
                let found = channels.iter().find(|c| c.name == wanted);
                let found = found.ok_or_else(|| none_such(&format!("channel {wanted}")))?;
                Ok(file.samples(found.id))
            };
            names.iter().map(plane).collect()
        };
        let (sharp, residual) = (planes("sharp")?, planes("residual")?);
        let Some(AttributeValue::IntegerBounds(plate)) = file.attribute(PLATE_WINDOW) else {
            return Err(none_such(PLATE_WINDOW));
        };
        let text = |name: &str| match file.attribute(name) {
            Some(AttributeValue::Text(text)) => Ok(text.to_string()),
            _ => Err(none_such(name)),
        };
        let noise: Vec<f64> = (text(NOISE)?.split_whitespace())
            .filter_map(|word| word.parse().ok().filter(|v: &f64| *v >= 0.0))
            .collect();
        if noise.len() != names.len() {
            return Err(none_such(NOISE));
        }
        let setting = |line: &str| {
            let (name, value) = line.split_once(": ")?;
            Some((name.to_owned(), value.to_owned()))
        };
        let residual = Self {
            path: path.to_owned(),
            windows: Windows {
                data: file.data_window(channels[0].id),
                display: file.display_window(),
            },
            plate: Window {
                x: plate.position.x(),
                y: plate.position.y(),
                width: plate.size.width(),
                height: plate.size.height(),
            },
            names: names.to_vec(),
            sharp,
            residual,
            noise,
            settings: text(SETTINGS)?.lines().filter_map(setting).collect(),
        };
        residual.check()?;
        Ok(residual)
    }

    /// Refuses samples that are not finite, and a plate that is not within the sharp picture.
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
        if self.windows.data.contains(self.plate) {
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

fn bounds(window: Window) -> IntegerBounds {
    IntegerBounds::new((window.x, window.y), (window.width, window.height))
}
