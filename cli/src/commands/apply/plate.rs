//! The light of a plate: its planes, premultiplied, and how lens channels act on them.

use clap::{Args, ValueEnum};
use seidel_core::field::ImagePoint;
use seidel_core::predict::Predictor;
use seidel_core::render::{BlurField, Plane, PlateMap, develop};
use seidel_core::{Error, Result};

use super::super::CommandError;
use crate::files::error::FileError;
use crate::files::flat_plate::Encoding;
use crate::files::plate::{Plate, PlateOptions};

/// Options about the plate.
#[derive(Debug, Args)]
pub(super) struct PlateArgs {
    /// EXR layer or part to blur; the root R, G, B (or Y) and A if left out
    #[arg(long)]
    layer: Option<String>,
    /// What integer samples of PNG and TIFF mean: srgb if left out; floats are linear
    #[arg(long, value_enum)]
    encoding: Option<EncodingChoice>,
    /// How colour and alpha go together; as the file says if left out (EXR premultiplied, PNG
    /// unpremultiplied, TIFF by its tag)
    #[arg(long, value_enum)]
    alpha: Option<AlphaChoice>,
    /// Replace NaN and infinite samples by zero, and say how many, instead of stopping
    #[arg(long)]
    scrub: bool,
    /// Plate pixels per pixel of the lens's frame; if left out the plate's display window is the
    /// lens's full frame
    #[arg(long, value_name = "RATIO", value_parser = parse_ratio)]
    pub(super) lens_scale: Option<f64>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum EncodingChoice {
    /// Proportional to light
    Linear,
    /// The sRGB transfer function
    Srgb,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AlphaChoice {
    /// Colour is multiplied by alpha
    Premultiplied,
    /// Colour is not multiplied by alpha
    Unpremultiplied,
}

fn parse_ratio(text: &str) -> std::result::Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|v| v.is_finite() && *v > 0.0)
        .ok_or_else(|| "give a number greater than zero".to_owned())
}

/// The planes of a plate as light: colour premultiplied, alpha last where there is one.
pub(super) struct Light {
    planes: Vec<Vec<f32>>,
    has_alpha: bool,
    unpremultiplied: bool,
}

impl PlateArgs {
    pub(super) fn options(&self) -> PlateOptions {
        PlateOptions {
            layer: self.layer.clone(),
            encoding: self.encoding.map(|choice| match choice {
                EncodingChoice::Linear => Encoding::Linear,
                EncodingChoice::Srgb => Encoding::Srgb,
            }),
        }
    }

    /// The planes to blur; remarks go to `said`.
    pub(super) fn light(
        &self,
        plate: &Plate,
        said: &mut Vec<String>,
    ) -> std::result::Result<Light, CommandError> {
        let bad = plate.non_finite();
        if let Some(first) = bad.first()
            && !self.scrub
        {
            return Err(FileError::new(
                plate.path(),
                "",
                first.to_string(),
                "mend the plate, or give --scrub to replace such samples by zero",
            )
            .into());
        }
        said.extend(bad.iter().map(|b| format!("{b}; replaced by zero")));
        let mut planes = plate.colour();
        let alpha = plate.alpha();
        let has_alpha = alpha.is_some();
        planes.extend(alpha);
        for sample in planes.iter_mut().flatten() {
            if !sample.is_finite() {
                *sample = 0.0;
            }
        }
        let unpremultiplied = has_alpha
            && match self.alpha {
                Some(choice) => choice == AlphaChoice::Unpremultiplied,
                None => !plate.is_premultiplied(),
            };
        if unpremultiplied && let Some((alpha, colour)) = planes.split_last_mut() {
            for plane in colour {
                for (sample, alpha) in plane.iter_mut().zip(alpha.iter()) {
                    *sample *= alpha;
                }
            }
        }
        Ok(Light {
            planes,
            has_alpha,
            unpremultiplied,
        })
    }
}

impl Light {
    /// How many planes there are, alpha included.
    pub(super) fn plane_count(&self) -> usize {
        self.planes.len()
    }

    /// The planes as they are.
    pub(super) fn copied(&self) -> Vec<Vec<f32>> {
        self.planes.clone()
    }

    /// The planes with the weights of [`plate_weights`].
    pub(super) fn with_weights<'a>(&'a self, weights: &'a [Vec<f64>]) -> Vec<Plane<'a>> {
        self.planes
            .iter()
            .zip(weights)
            .map(|(samples, weights)| Plane { samples, weights })
            .collect()
    }

    /// Turns the light of blurred colour planes into what the lens's sensor records; alpha stays.
    pub(super) fn develop(&self, lens: &Predictor, weights: &[Vec<f64>], blurred: &mut [Vec<f32>]) {
        let colours = blurred.len() - usize::from(self.has_alpha);
        for (plane, weights) in blurred[..colours].iter_mut().zip(weights) {
            develop(lens, weights, plane);
        }
    }

    /// Puts blurred planes back into the plate, in the plate's own premultiplication.
    pub(super) fn put_back(
        &self,
        plate: &mut Plate,
        mut blurred: Vec<Vec<f32>>,
    ) -> std::result::Result<(), CommandError> {
        let alpha = self.has_alpha.then(|| blurred.pop()).flatten();
        if self.unpremultiplied
            && let Some(alpha) = &alpha
        {
            for plane in &mut blurred {
                for (sample, &alpha) in plane.iter_mut().zip(alpha) {
                    // Where nothing covers the pixel its colour is as good as any.
                    *sample = if alpha > 0.0 { *sample / alpha } else { 0.0 };
                }
            }
        }
        plate.set_colour(&blurred)?;
        if let Some(alpha) = &alpha {
            plate.set_alpha(alpha)?;
        }
        Ok(())
    }
}

/// How much each lens channel acts on each plane of the plate, alpha last: a colour plane takes the
/// lens channel of its name, or the only one there is; a monochrome plate takes all alike; alpha is
/// blurred by the mean of what blurs the colours, so that it covers the light of every channel.
///
/// # Errors
/// A colour plane for which the lens has no channel.
pub(super) fn plate_weights(plate: &Plate, lens: &Predictor) -> Result<Vec<Vec<f64>>> {
    let names = lens.channel_names();
    let mut weights: Vec<Vec<f64>> = Vec::new();
    for name in plate.colour_names() {
        let own = names.iter().position(|n| n == name);
        let chosen = match own {
            Some(index) => (0..names.len())
                .map(|k| f64::from(u8::from(k == index)))
                .collect(),
            None if names.len() == 1 => vec![1.0],
            None if name == "Y" => vec![1.0 / names.len() as f64; names.len()],
            None => {
                return Err(Error::new(
                    format!("channel {name}"),
                    format!(
                        "has no counterpart in the lens, which has {}",
                        names.join(", ")
                    ),
                    "use a lens with this channel, or one with a single channel",
                ));
            }
        };
        weights.push(chosen);
    }
    if plate.has_alpha() {
        let count = weights.len() as f64;
        let mean = (0..names.len())
            .map(|k| weights.iter().map(|w| w[k]).sum::<f64>() / count)
            .collect();
        weights.push(mean);
    }
    Ok(weights)
}

/// Where the plate lies in the lens's frame: centre on centre, the display window as wide as the
/// frame unless `scale` says otherwise.
pub(super) fn plate_map(plate: &Plate, lens: &Predictor, scale: Option<f64>) -> PlateMap {
    let frame = lens.frame();
    let (display, data) = (plate.display_window(), plate.data_window());
    let scale = scale.unwrap_or(display.width as f64 / f64::from(frame.width_px()));
    let corner = |size: u32, display_start: i32, display_size: usize, data_start: i32| {
        let from_centre =
            f64::from(data_start) - f64::from(display_start) - display_size as f64 / 2.0;
        f64::from(size) / 2.0 + from_centre / scale
    };
    PlateMap {
        origin: ImagePoint::new(
            corner(frame.width_px(), display.x, display.width, data.x),
            corner(frame.height_px(), display.y, display.height, data.y),
        ),
        scale,
    }
}
