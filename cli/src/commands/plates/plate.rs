//! The light of a plate: its planes, premultiplied, and how lens channels act on them.

use clap::{Args, ValueEnum};
use rayon::prelude::*;
use seidel_core::field::ImagePoint;
use seidel_core::predict::Predictor;
use seidel_core::render::{BlurField, MOST_PIXEL_ASPECT, Plane, PlateMap, develop};
use seidel_core::{Error, Result};

use crate::commands::CommandError;
use crate::files::error::FileError;
use crate::files::flat_plate::Encoding;
use crate::files::plate::{Plate, PlateOptions};

/// Options about the plate.
#[derive(Debug, Args)]
pub(crate) struct PlateArgs {
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
    /// Write the blurred alpha of each colour as alpha.R, alpha.G, alpha.B beside A, so that colour fringes
    /// survive a merge: each is blurred as its colour is. Where the plate has such channels they are taken as
    /// the alpha of their colours. EXR only
    #[arg(long)]
    alpha_per_channel: bool,
    /// Replace NaN and infinite samples by zero, and say how many, instead of stopping
    #[arg(long)]
    scrub: bool,
    /// Plate pixels per pixel of the lens's frame, counted along y; if left out the plate's display window is as
    /// wide as the lens's full frame, pixel aspect included
    #[arg(long, value_name = "RATIO", value_parser = parse_ratio)]
    pub(crate) lens_scale: Option<f64>,
    /// Width of a plate pixel over its height, such as 2 for an anamorphic plate not yet desqueezed; if left out
    /// as the EXR's pixelAspectRatio says, 1 for PNG and TIFF. The lens sees the plate as wide as its pixels make
    /// it: blur and displacement along x are 1/P as many pixels
    #[arg(long, value_name = "P", value_parser = parse_ratio)]
    pixel_aspect: Option<f64>,
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

/// The planes of a plate as light: colour premultiplied, then alpha where there is one, then the alpha of each
/// colour alone where asked for.
pub(crate) struct Light {
    planes: Vec<Vec<f32>>,
    names: Vec<String>,
    colours: usize,
    own_alphas: usize,
    has_alpha: bool,
    unpremultiplied: bool,
}

impl PlateArgs {
    pub(crate) fn options(&self) -> PlateOptions {
        PlateOptions {
            layer: self.layer.clone(),
            encoding: self.encoding.map(|choice| match choice {
                EncodingChoice::Linear => Encoding::Linear,
                EncodingChoice::Srgb => Encoding::Srgb,
            }),
            alpha_per_channel: self.alpha_per_channel,
        }
    }

    /// Width of the plate's pixels over their height.
    ///
    /// # Errors
    /// One that no renderer follows.
    pub(crate) fn pixel_aspect(&self, plate: &Plate) -> std::result::Result<f64, CommandError> {
        let aspect = self.pixel_aspect.unwrap_or_else(|| plate.pixel_aspect());
        if (1.0 / MOST_PIXEL_ASPECT..=MOST_PIXEL_ASPECT).contains(&aspect) {
            return Ok(aspect);
        }
        let source = match self.pixel_aspect {
            Some(_) => "--pixel-aspect",
            None => "pixelAspectRatio",
        };
        Err(FileError::new(
            plate.path(),
            source,
            format!("is {aspect}"),
            format!(
                "give --pixel-aspect from 1/{MOST_PIXEL_ASPECT} to {MOST_PIXEL_ASPECT}, 1 for square pixels"
            ),
        )
        .into())
    }

    /// The planes to blur; remarks go to `said`.
    pub(crate) fn light(
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
        let colours = planes.len();
        let alpha = plate.alpha();
        let has_alpha = alpha.is_some();
        planes.extend(alpha);
        let own_alphas = plate.own_alphas();
        let count = own_alphas.len();
        planes.extend(own_alphas);
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
        let mut names = plate.colour_names().to_vec();
        names.extend(has_alpha.then(|| "A".to_owned()));
        let of_colour = |name: &String| format!("alpha.{name}");
        names.extend(plate.colour_names().iter().take(count).map(of_colour));
        let mut light = Light {
            planes,
            names,
            colours,
            own_alphas: count,
            has_alpha,
            unpremultiplied,
        };
        if unpremultiplied {
            let mut planes = std::mem::take(&mut light.planes);
            light.by_alpha(&mut planes, |colour, alpha| colour * alpha);
            light.planes = planes;
        }
        Ok(light)
    }
}

impl Light {
    /// How many planes there are, alpha included.
    pub(crate) fn plane_count(&self) -> usize {
        self.planes.len()
    }

    /// How many planes are colour, the first ones.
    pub(crate) fn colour_count(&self) -> usize {
        self.colours
    }

    /// The largest size of a colour sample.
    pub(crate) fn peak(&self) -> f64 {
        let samples = self.planes[..self.colours].iter().flatten();
        f64::from(samples.fold(0.0, |most: f32, v| most.max(v.abs())))
    }

    /// The planes as they are.
    pub(crate) fn copied(&self) -> Vec<Vec<f32>> {
        self.planes.clone()
    }

    /// The planes with the weights of [`plate_weights`].
    pub(crate) fn with_weights<'a>(&'a self, weights: &'a [Vec<f64>]) -> Vec<Plane<'a>> {
        self.planes
            .iter()
            .zip(weights)
            .map(|(samples, weights)| Plane { samples, weights })
            .collect()
    }

    /// Turns the light of blurred colour planes into what the lens's sensor records; alpha stays.
    pub(crate) fn develop(&self, lens: &Predictor, weights: &[Vec<f64>], blurred: &mut [Vec<f32>]) {
        for (plane, weights) in blurred[..self.colours].iter_mut().zip(weights) {
            develop(lens, weights, plane);
        }
    }

    /// Turns what the lens's sensor recorded back into the light of the colour planes: undoes [`Light::develop`]. Of
    /// what is clipped, the least light that is.
    pub(crate) fn undevelop(&mut self, lens: &Predictor, weights: &[Vec<f64>]) {
        for (plane, weights) in self.planes[..self.colours].iter_mut().zip(weights) {
            let shares = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
            let tones: Vec<_> = shares.map(|(k, w)| (lens.tone(k), *w)).collect();
            if tones.iter().all(|(tone, _)| tone.is_linear()) {
                continue;
            }
            let seen = |light: f64| tones.iter().map(|(tone, w)| w * tone.of(light)).sum();
            plane.par_iter_mut().for_each(|sample| {
                *sample = light_of(f64::from(*sample), seen) as f32;
            });
        }
    }

    /// Other planes in place of these, of any one size.
    pub(crate) fn with_planes(&self, planes: Vec<Vec<f32>>) -> Self {
        Self {
            planes,
            names: self.names.clone(),
            ..*self
        }
    }

    /// The planes.
    pub(crate) fn planes(&self) -> &[Vec<f32>] {
        &self.planes
    }

    /// Their names: R, G, B or Y, then A, then alpha.R and so on.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Leaves `plate` as it is, to the bit and not only to the rounding of a render; but for what was scrubbed.
    pub(crate) fn keep(&self, plate: &mut Plate) -> std::result::Result<(), CommandError> {
        match plate.non_finite().is_empty() {
            true => Ok(()),
            false => self.put_back(plate, self.copied()),
        }
    }

    /// Puts blurred planes back into the plate, in the plate's own premultiplication.
    pub(crate) fn put_back(
        &self,
        plate: &mut Plate,
        mut blurred: Vec<Vec<f32>>,
    ) -> std::result::Result<(), CommandError> {
        if self.unpremultiplied {
            self.by_alpha(&mut blurred, |colour, alpha| {
                // Where nothing covers the pixel its colour is as good as any.
                if alpha > 0.0 { colour / alpha } else { 0.0 }
            });
        }
        let mut alphas = blurred.split_off(self.colours);
        plate.set_colour(&blurred)?;
        let own_alphas = alphas.split_off(usize::from(self.has_alpha));
        if let Some(alpha) = alphas.first() {
            plate.set_alpha(alpha)?;
        }
        plate.set_own_alphas(&own_alphas)?;
        Ok(())
    }

    /// Puts `change` of each colour sample and its alpha in place of the colour: its own alpha where it has
    /// one.
    fn by_alpha(&self, planes: &mut [Vec<f32>], change: impl Fn(f32, f32) -> f32) {
        let (colours, alphas) = planes.split_at_mut(self.colours);
        for (index, plane) in colours.iter_mut().enumerate() {
            let own = (index < self.own_alphas).then_some(1 + index);
            for (sample, alpha) in plane.iter_mut().zip(&alphas[own.unwrap_or(0)]) {
                *sample = change(*sample, *alpha);
            }
        }
    }
}

/// Light beyond which no sensor tells more from less.
const MOST_LIGHT: f64 = 1e6;

/// The least light that is `seen`, which grows with light and is odd, as `sample`: by bisection.
fn light_of(sample: f64, seen: impl Fn(f64) -> f64) -> f64 {
    let size = sample.abs().min(seen(MOST_LIGHT));
    let (mut low, mut high) = (0.0, MOST_LIGHT);
    for _ in 0..64 {
        let middle = (low + high) / 2.0;
        if seen(middle) < size * (1.0 - 1e-9) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high.copysign(sample)
}

/// How much each lens channel acts on each plane of the plate, in the order of [`Light`]: a colour plane takes
/// the lens channel of its name, or the only one there is; a monochrome plate takes all alike; alpha is
/// blurred by the mean of what blurs the colours, so that it covers the light of every channel; the alpha of one
/// colour is blurred as that colour.
///
/// # Errors
/// A colour plane for which the lens has no channel.
pub(crate) fn plate_weights(plate: &Plate, lens: &Predictor) -> Result<Vec<Vec<f64>>> {
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
        let of_colours = if plate.has_own_alphas() {
            weights.clone()
        } else {
            Vec::new()
        };
        weights.push(mean);
        weights.extend(of_colours);
    }
    Ok(weights)
}

/// Where the plate lies in the lens's frame, or where pixels are not square in that of
/// [`NonSquare`](seidel_core::render::NonSquare): centre on centre, the display window as wide as the frame unless
/// `scale` says otherwise.
pub(crate) fn plate_map(
    plate: &Plate,
    lens: &Predictor,
    scale: Option<f64>,
    pixel_aspect: f64,
) -> PlateMap {
    let frame = lens.frame();
    let (display, data) = (plate.display_window(), plate.data_window());
    let square_width = display.width as f64 * pixel_aspect;
    let scale = scale.unwrap_or(square_width / f64::from(frame.width_px()));
    let corner = |size: f64, display_start: i32, display_size: usize, data_start: i32| {
        let from_centre =
            f64::from(data_start) - f64::from(display_start) - display_size as f64 / 2.0;
        size / 2.0 + from_centre / scale
    };
    let width = f64::from(frame.width_px()) / pixel_aspect;
    let height = f64::from(frame.height_px());
    PlateMap {
        origin: ImagePoint::new(
            corner(width, display.x, display.width, data.x),
            corner(height, display.y, display.height, data.y),
        ),
        scale,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_core::sensor::Tone;

    #[test]
    fn light_is_told_from_what_a_sensor_makes_of_it() {
        let tone = Tone {
            gamma: 0.8,
            knee: 0.5,
            clip: 1.2,
        };
        for light in [0.0, 0.001, 0.3, 1.0, -0.4] {
            let found = light_of(tone.of(light), |l| tone.of(l));
            assert!((found - light).abs() < 1e-6, "{light}: {found}");
        }
        let clipped = light_of(1.2, |l| tone.of(l));
        assert!(
            clipped < 4.0 && (tone.of(clipped) - 1.2).abs() < 1e-6,
            "{clipped}"
        );
    }
}
