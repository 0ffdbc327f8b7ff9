//! The planes of an image as renderers work on them: premultiplied, in scene-linear light.

use rayon::prelude::*;
use seidel_optics::BlurField;
use seidel_optics::apply_tone;
use seidel_optics::error::{Error, Result};
use seidel_optics::predict::Predictor;
use seidel_render::Plane;

use crate::finite::first_non_finite;
use crate::image::{AlphaKind, Image};
use crate::light_scale::LightScale;
use crate::margins::Margins;

/// The planes of an image: premultiplied colours, then alpha where there is one, then the alpha of each colour where
/// there are those.
#[derive(Debug, Clone)]
pub(crate) struct PremultipliedPlanes {
    width: usize,
    height: usize,
    planes: Vec<Vec<f32>>,
    layout: PlaneLayout,
}

/// Planes whose colours were multiplied by a scale.
pub(crate) struct ReducedPlanes {
    pub(crate) planes: PremultipliedPlanes,
    pub(crate) scale: LightScale,
}

/// The names and kinds of an image's planes.
#[derive(Debug, Clone)]
pub(crate) struct PlaneLayout {
    pub(crate) colour_names: Vec<String>,
    pub(crate) has_alpha: bool,
    pub(crate) has_channel_alphas: bool,
    alpha_kind: AlphaKind,
}

impl PremultipliedPlanes {
    /// Takes the planes of `image`.
    ///
    /// # Errors
    /// Planes of different sizes, and samples that are not finite.
    pub(crate) fn new(image: Image) -> Result<Self> {
        image.check_sizes()?;
        image.check_finite()?;
        let mut all = Self {
            width: image.width(),
            height: image.height(),
            planes: Vec::new(),
            layout: PlaneLayout {
                has_alpha: image.alpha.is_some(),
                has_channel_alphas: !image.channel_alphas.is_empty(),
                alpha_kind: image.alpha_kind,
                colour_names: image.names,
            },
        };
        let mut planes = image.colours;
        planes.extend(image.alpha);
        planes.extend(image.channel_alphas);
        let multiplies = all.is_unpremultiplied();
        if multiplies {
            all.map_colours(&mut planes, |colour, alpha| colour * alpha);
        }
        all.planes = planes;
        if multiplies {
            all.check_products()?;
        }
        Ok(all)
    }

    /// Checks that colours multiplied by alpha are finite.
    fn check_products(&self) -> Result<()> {
        for (name, plane) in self.names().iter().zip(&self.planes) {
            if let Some(at) = first_non_finite(plane) {
                return Err(Error::new(
                    format!(
                        "channel {name}, pixel ({}, {})",
                        at % self.width,
                        at / self.width
                    ),
                    "times its alpha is too large for 32-bit floats",
                    "scale the plate down, or correct its alpha, which is 0 to 1",
                ));
            }
        }
        Ok(())
    }

    /// The names and kinds of the planes.
    pub(crate) fn layout(&self) -> &PlaneLayout {
        &self.layout
    }

    /// Number of colour planes, which come first.
    pub(crate) fn colour_count(&self) -> usize {
        self.layout.colour_names.len()
    }

    /// Largest magnitude of a colour sample.
    pub(crate) fn peak(&self) -> f64 {
        // Bits of magnitudes compare as integers, which takes vector instructions.
        let largest = |plane: &Vec<f32>| plane.iter().map(|v| v.abs().to_bits()).max();
        let colours = self.planes[..self.colour_count()].par_iter();
        let bits = colours.filter_map(largest);
        f64::from(f32::from_bits(bits.max().unwrap_or(0)))
    }

    /// All planes.
    pub(crate) fn planes(&self) -> &[Vec<f32>] {
        &self.planes
    }

    /// Names of all planes: R, G, B or Y, then A, then alpha.R and so on.
    pub(crate) fn names(&self) -> Vec<String> {
        let own = if self.layout.has_channel_alphas {
            &self.layout.colour_names[..]
        } else {
            &[]
        };
        let own = own.iter().map(|name| format!("alpha.{name}"));
        (self.layout.colour_names.iter().cloned())
            .chain(self.layout.has_alpha.then(|| "A".to_owned()))
            .chain(own)
            .collect()
    }

    /// The same image with other `planes`, of any one size.
    pub(crate) fn with_planes(&self, planes: Vec<Vec<f32>>) -> Self {
        Self {
            planes,
            layout: self.layout.clone(),
            ..*self
        }
    }

    /// Returns the planes as those of an image of `layout`: without alpha where it has none, and opaque where only it has
    /// alpha.
    ///
    /// # Errors
    /// An image without one of its colours.
    pub(crate) fn with_layout(&self, layout: &PlaneLayout) -> Result<Self> {
        let plane = |name: &String| {
            let own = self.layout.colour_names.iter();
            let index = own.into_iter().position(|own| own == name);
            index.map(|index| &self.planes[index]).ok_or_else(|| {
                Error::new(
                    "image",
                    format!(
                        "has no channel {name}, but {}",
                        self.layout.colour_names.join(", ")
                    ),
                    "give one with the colours of the plate",
                )
            })
        };
        let colours = layout.colour_names.iter().map(plane);
        let mut planes: Vec<Vec<f32>> = colours.map(|p| p.cloned()).collect::<Result<_>>()?;
        let opaque = || vec![1.0; self.width * self.height];
        let alpha = (self.layout.has_alpha).then(|| &self.planes[self.colour_count()]);
        let alphas = if layout.has_channel_alphas {
            layout.colour_names.len()
        } else {
            0
        };
        for _ in 0..usize::from(layout.has_alpha) + alphas {
            planes.push(alpha.cloned().unwrap_or_else(opaque));
        }
        Ok(Self {
            planes,
            layout: layout.clone(),
            ..*self
        })
    }

    /// The image with `margins` of transparent black about it.
    pub(crate) fn padded(&self, margins: Margins) -> Self {
        let padded = |plane: &Vec<f32>| margins.padded(plane, self.width, |_| 0.0);
        Self {
            width: self.width + margins.left + margins.right,
            height: self.height + margins.top + margins.bottom,
            planes: self.planes.iter().map(padded).collect(),
            layout: self.layout.clone(),
        }
    }

    /// Returns the planes with colours multiplied by a scale.
    pub(crate) fn reduced_by(&self, scale: LightScale) -> Self {
        let mut planes = self.clone();
        let colours = self.colour_count();
        for plane in &mut planes.planes[..colours] {
            scale.reduce(plane);
        }
        planes
    }

    /// Returns the scale that the colours need so that arithmetic on them cannot overflow, and the planes with scaled
    /// colours; `None` if they need none.
    pub(crate) fn reduced(&self) -> Option<ReducedPlanes> {
        let scale = LightScale::for_peak(self.peak())?;
        let planes = self.reduced_by(scale);
        Some(ReducedPlanes { planes, scale })
    }

    /// The planes with their channel `weights`, as renderers take them.
    pub(crate) fn weighted<'a>(&'a self, weights: &'a [Vec<f64>]) -> Vec<Plane<'a>> {
        self.planes
            .iter()
            .zip(weights)
            .map(|(samples, weights)| Plane { samples, weights })
            .collect()
    }

    /// Turns the light of `blurred` colour planes into what the lens's sensor records; alpha stays.
    pub(crate) fn develop(&self, lens: &Predictor, weights: &[Vec<f64>], blurred: &mut [Vec<f32>]) {
        for (plane, weights) in blurred.iter_mut().take(self.colour_count()).zip(weights) {
            apply_tone(lens, weights, plane);
        }
    }

    /// Turns what the lens's sensor recorded back into light: the inverse of [`Self::develop`]. A clipped sample becomes
    /// the least light that is clipped.
    pub(crate) fn undevelop(&mut self, lens: &Predictor, weights: &[Vec<f64>]) {
        let colours = self.colour_count();
        for (plane, weights) in self.planes[..colours].iter_mut().zip(weights) {
            let shares = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
            let tones: Vec<_> = shares.map(|(k, w)| (lens.tone(k), *w)).collect();
            if tones.iter().all(|(tone, _)| tone.is_linear()) {
                continue;
            }
            let recorded = |light: f64| tones.iter().map(|(tone, w)| w * tone.apply(light)).sum();
            plane.par_iter_mut().for_each(|sample| {
                *sample = invert_tone(f64::from(*sample), recorded) as f32;
            });
        }
    }

    /// Returns `planes`, as large as those of this image, as an image with its relation of colour and alpha. The colour
    /// of a pixel that is not covered is zero where colours are not premultiplied.
    ///
    /// # Errors
    /// The first sample that is not finite, by channel and pixel: the computation overflowed. The first pixel of `planes`, which are
    /// of the size `width` x `height`, is that of column and row `first` on the plate.
    pub(crate) fn to_image(
        &self,
        first: [i64; 2],
        width: usize,
        height: usize,
        mut planes: Vec<Vec<f32>>,
    ) -> Result<Image> {
        if self.is_unpremultiplied() {
            self.map_colours(
                &mut planes,
                |colour, alpha| {
                    if alpha > 0.0 { colour / alpha } else { 0.0 }
                },
            );
        }
        let mut rest = planes.into_iter();
        let image = Image::from_planes(
            width,
            height,
            self.layout.colour_names.clone(),
            rest.by_ref().take(self.colour_count()).collect(),
        )
        .with_alpha(
            if self.layout.has_alpha {
                rest.next()
            } else {
                None
            },
            rest.collect(),
            self.layout.alpha_kind,
        );
        image.check_computed(first)?;
        Ok(image)
    }

    fn is_unpremultiplied(&self) -> bool {
        self.layout.has_alpha && self.layout.alpha_kind == AlphaKind::Unpremultiplied
    }

    /// Replaces each colour sample by `change` of it and its alpha: the alpha of its own colour where there is one.
    fn map_colours(&self, planes: &mut [Vec<f32>], change: impl Fn(f32, f32) -> f32) {
        let (colours, alphas) = planes.split_at_mut(self.colour_count());
        for (index, plane) in colours.iter_mut().enumerate() {
            let alpha = if self.layout.has_channel_alphas {
                1 + index
            } else {
                0
            };
            for (sample, alpha) in plane.iter_mut().zip(&alphas[alpha]) {
                *sample = change(*sample, *alpha);
            }
        }
    }
}

/// Light beyond which tone curves are taken to be flat: the upper end of the bisection.
const MOST_LIGHT: f64 = 1e6;

/// Returns the least light that `recorded`, an odd and increasing function, maps to `sample`: by bisection.
fn invert_tone(sample: f64, recorded: impl Fn(f64) -> f64) -> f64 {
    let size = sample.abs().min(recorded(MOST_LIGHT));
    let (mut low, mut high) = (0.0, MOST_LIGHT);
    for _ in 0..64 {
        let middle = (low + high) / 2.0;
        if recorded(middle) < size * (1.0 - 1e-9) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high.copysign(sample)
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::sensor::Tone;

    #[test]
    fn invert_tone_returns_the_light_that_was_recorded() {
        let tone = Tone {
            gamma: 0.8,
            knee: 0.5,
            clip: 1.2,
        };
        for light in [0.0, 0.001, 0.3, 1.0, -0.4] {
            let found = invert_tone(tone.apply(light), |l| tone.apply(l));
            assert!((found - light).abs() < 1e-6, "{light}: {found}");
        }
        let clipped = invert_tone(1.2, |l| tone.apply(l));
        assert!(
            clipped < 4.0 && (tone.apply(clipped) - 1.2).abs() < 1e-6,
            "{clipped}"
        );
    }

    #[test]
    fn each_colour_is_multiplied_by_its_own_alpha() -> Result<()> {
        let colours = vec![vec![0.5, 0.8], vec![0.5, 0.7]];
        let image = Image::new(2, 1, vec!["R".into(), "G".into()], colours)?.with_alpha(
            Some(vec![0.5, 0.0]),
            vec![vec![0.25, 0.5], vec![1.0, 0.0]],
            AlphaKind::Unpremultiplied,
        );
        let planes = PremultipliedPlanes::new(image.clone())?;
        assert_eq!(planes.names(), ["R", "G", "A", "alpha.R", "alpha.G"]);
        assert_eq!(planes.planes()[..2], [vec![0.125, 0.4], vec![0.5, 0.0]]);
        let back = planes.to_image([0; 2], 2, 1, planes.planes().to_vec())?;
        assert_eq!(back.colours, [vec![0.5, 0.8], vec![0.5, 0.0]]);
        assert_eq!(back.channel_alphas, image.channel_alphas);
        Ok(())
    }

    #[test]
    fn samples_that_are_not_finite_are_refused_by_channel_and_pixel() -> Result<()> {
        let mut image = Image::new(2, 1, vec!["Y".into()], vec![vec![0.5, f32::NAN]])?;
        let refused = PremultipliedPlanes::new(image.clone());
        let place = refused.err().map(|error| error.place);
        assert_eq!(place.as_deref(), Some("channel Y, pixel (1, 0)"));
        assert_eq!(image.replace_non_finite(), 1);
        assert_eq!(image.colours[0], [0.5, 0.0]);
        PremultipliedPlanes::new(image).map(|_| ())
    }
}
