//! The light of a plate: its planes, premultiplied, and what the sensor does to them.

use crate::{BlurField, Plane, apply_tone};
use rayon::prelude::*;
use seidel_optics::predict::Predictor;

/// The planes of a plate as a file or host has them, row-major, all of one size.
#[derive(Debug, Clone, Default)]
pub struct LightParts {
    /// Names of the colours: R, G, B, or Y.
    pub names: Vec<String>,
    /// One plane each.
    pub colours: Vec<Vec<f32>>,
    /// Coverage, 0 to 1.
    pub alpha: Option<Vec<f32>>,
    /// Coverage as each colour alone sees it: one plane a colour, or none. Only where there is an alpha.
    pub own_alphas: Vec<Vec<f32>>,
    /// Whether colours are not multiplied by their alpha yet.
    pub unpremultiplied: bool,
}

/// The planes of a plate as light: colour premultiplied, then alpha where there is one, then the alpha of each
/// colour alone where there are those.
#[derive(Debug, Clone)]
pub struct Light {
    planes: Vec<Vec<f32>>,
    names: Vec<String>,
    colours: usize,
    own_alphas: usize,
    has_alpha: bool,
    unpremultiplied: bool,
}

/// Planes in the plate's own premultiplication.
#[derive(Debug, Clone, PartialEq)]
pub struct Returned {
    /// The colours.
    pub colours: Vec<Vec<f32>>,
    /// Their common alpha, where there is one.
    pub alpha: Option<Vec<f32>>,
    /// The alpha of each colour, where there are those.
    pub own_alphas: Vec<Vec<f32>>,
}

impl Light {
    /// Of `parts`; samples that are not finite count as zero.
    pub fn new(parts: LightParts) -> Self {
        let colours = parts.colours.len();
        let has_alpha = parts.alpha.is_some();
        let own_alphas = parts.own_alphas.len();
        let mut names = parts.names;
        names.truncate(colours);
        let of_colour = |name: &String| format!("alpha.{name}");
        let own: Vec<String> = names.iter().take(own_alphas).map(of_colour).collect();
        names.extend(has_alpha.then(|| "A".to_owned()));
        names.extend(own);
        let mut planes = parts.colours;
        planes.extend(parts.alpha);
        planes.extend(parts.own_alphas);
        for sample in planes.iter_mut().flatten() {
            if !sample.is_finite() {
                *sample = 0.0;
            }
        }
        let mut light = Self {
            planes,
            names,
            colours,
            own_alphas,
            has_alpha,
            unpremultiplied: has_alpha && parts.unpremultiplied,
        };
        if light.unpremultiplied {
            let mut planes = std::mem::take(&mut light.planes);
            light.by_alpha(&mut planes, |colour, alpha| colour * alpha);
            light.planes = planes;
        }
        light
    }

    /// How many planes there are, alpha included.
    pub fn plane_count(&self) -> usize {
        self.planes.len()
    }

    /// How many planes are colour, the first ones.
    pub fn colour_count(&self) -> usize {
        self.colours
    }

    /// Whether the plate's colours are not multiplied by their alpha.
    pub fn is_unpremultiplied(&self) -> bool {
        self.unpremultiplied
    }

    /// The largest size of a colour sample.
    pub fn peak(&self) -> f64 {
        let samples = self.planes[..self.colours].iter().flatten();
        f64::from(samples.fold(0.0, |most: f32, v| most.max(v.abs())))
    }

    /// The planes as they are.
    pub fn copied(&self) -> Vec<Vec<f32>> {
        self.planes.clone()
    }

    /// The planes with the weights of [`plate_weights`](super::plate_weights).
    pub fn with_weights<'a>(&'a self, weights: &'a [Vec<f64>]) -> Vec<Plane<'a>> {
        self.planes
            .iter()
            .zip(weights)
            .map(|(samples, weights)| Plane { samples, weights })
            .collect()
    }

    /// Turns the light of blurred colour planes into what the lens's sensor records; alpha stays.
    pub fn develop(&self, lens: &Predictor, weights: &[Vec<f64>], blurred: &mut [Vec<f32>]) {
        for (plane, weights) in blurred.iter_mut().take(self.colours).zip(weights) {
            apply_tone(lens, weights, plane);
        }
    }

    /// Turns what the lens's sensor recorded back into the light of the colour planes: undoes [`Light::develop`]. Of
    /// what is clipped, the least light that is.
    pub fn undevelop(&mut self, lens: &Predictor, weights: &[Vec<f64>]) {
        for (plane, weights) in self.planes[..self.colours].iter_mut().zip(weights) {
            let shares = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
            let tones: Vec<_> = shares.map(|(k, w)| (lens.tone(k), *w)).collect();
            if tones.iter().all(|(tone, _)| tone.is_linear()) {
                continue;
            }
            let seen = |light: f64| tones.iter().map(|(tone, w)| w * tone.apply(light)).sum();
            plane.par_iter_mut().for_each(|sample| {
                *sample = light_of(f64::from(*sample), seen) as f32;
            });
        }
    }

    /// Other planes in place of these, of any one size.
    #[must_use]
    pub fn with_planes(&self, planes: Vec<Vec<f32>>) -> Self {
        Self {
            planes,
            names: self.names.clone(),
            ..*self
        }
    }

    /// The planes.
    pub fn planes(&self) -> &[Vec<f32>] {
        &self.planes
    }

    /// Their names: R, G, B or Y, then A, then alpha.R and so on.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Blurred planes in the plate's own premultiplication. Where nothing covers a pixel of a plate that is not
    /// premultiplied its colour is zero.
    pub fn returned(&self, mut blurred: Vec<Vec<f32>>) -> Returned {
        if self.unpremultiplied {
            self.by_alpha(&mut blurred, |colour, alpha| {
                // Where nothing covers the pixel its colour is as good as any.
                if alpha > 0.0 { colour / alpha } else { 0.0 }
            });
        }
        let mut rest = blurred.into_iter();
        Returned {
            colours: rest.by_ref().take(self.colours).collect(),
            alpha: if self.has_alpha { rest.next() } else { None },
            own_alphas: rest.collect(),
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::sensor::Tone;

    #[test]
    fn light_is_told_from_what_a_sensor_makes_of_it() {
        let tone = Tone {
            gamma: 0.8,
            knee: 0.5,
            clip: 1.2,
        };
        for light in [0.0, 0.001, 0.3, 1.0, -0.4] {
            let found = light_of(tone.apply(light), |l| tone.apply(l));
            assert!((found - light).abs() < 1e-6, "{light}: {found}");
        }
        let clipped = light_of(1.2, |l| tone.apply(l));
        assert!(
            clipped < 4.0 && (tone.apply(clipped) - 1.2).abs() < 1e-6,
            "{clipped}"
        );
    }

    #[test]
    fn each_colour_goes_by_its_own_alpha_where_it_has_one() {
        let parts = LightParts {
            names: vec!["R".into(), "G".into()],
            colours: vec![vec![0.5, 0.8], vec![0.5, f32::NAN]],
            alpha: Some(vec![0.5, 0.0]),
            own_alphas: vec![vec![0.25, 0.5], vec![1.0, 0.0]],
            unpremultiplied: true,
        };
        let light = Light::new(parts.clone());
        assert_eq!(light.names(), ["R", "G", "A", "alpha.R", "alpha.G"]);
        assert_eq!(light.planes()[..2], [vec![0.125, 0.4], vec![0.5, 0.0]]);
        let back = light.returned(light.copied());
        assert_eq!(back.colours, [vec![0.5, 0.8], vec![0.5, 0.0]]);
        assert_eq!(
            (back.alpha, back.own_alphas),
            (parts.alpha, parts.own_alphas)
        );
        let plain = Light::new(LightParts {
            names: vec!["Y".into()],
            colours: vec![vec![0.5]],
            unpremultiplied: true,
            ..LightParts::default()
        });
        assert_eq!((plain.plane_count(), plain.planes()), (1, &[vec![0.5]][..]));
        assert_eq!(plain.returned(plain.copied()).alpha, None);
    }
}
