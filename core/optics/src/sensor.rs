//! What the sensor does to the picture that a lens draws on it: the same everywhere in the frame.
//!
//! Four things in this order: the picture moves during the exposure ([`Sensor::streak_px`]), a low-pass
//! filter copies it and pixels integrate over more than their own square ([`Sensor::copies_px`],
//! [`Sensor::box_px`]), a part of the light scatters ([`Halo`]), and values are not proportional to
//! light ([`Tone`]). All but the last are linear and keep light.

use crate::moments::CentralMoments;

/// A sensor, lengths in px. The default one is ideal and does nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensor {
    /// The picture's path (x, y) in the exposure: light is spread evenly along it, middle where the
    /// picture would be at rest.
    pub streak_px: [f64; 2],
    /// Sides (x, y) of the box that light is spread over besides the pixel's own square.
    pub box_px: [f64; 2],
    /// Distances along x and y between the four copies of the picture behind a low-pass filter.
    pub copies_px: [f64; 2],
    /// Light that scatters far.
    pub halo: Halo,
    /// How pixel values follow from light.
    pub tone: Tone,
}

/// A share of the light that lands about its point with a density of `(1 + r²/radius²)^-steepness`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Halo {
    /// Share of the light, 0 to 1.
    pub share: f64,
    /// Radius, px.
    pub radius_px: f64,
    /// How fast it falls off: above one; the larger, the more like a Gaussian.
    pub steepness: f64,
    /// How many times as far it goes along x: other than one on pixels that are not square.
    pub stretch_x: f64,
}

impl Halo {
    /// The radius along y beyond which it carries no more than `share` of all light, px.
    pub fn radius_holding(&self, share: f64) -> f64 {
        if self.share <= share {
            return 0.0;
        }
        let beyond = (self.share / share).powf(1.0 / (self.steepness - 1.0));
        self.radius_px * (beyond - 1.0).sqrt()
    }
}

impl Default for Halo {
    fn default() -> Self {
        Self {
            share: 0.0,
            radius_px: 4.0,
            steepness: 2.0,
            stretch_x: 1.0,
        }
    }
}

/// Pixel values v of linear values l in which white is one: `l' = l^gamma / (1 + knee l^gamma)` scaled to
/// keep one at one, then clipped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Exponent; below one lifts the dark.
    pub gamma: f64,
    /// How strongly the bright are compressed; negative stretches them. Above -1.
    pub knee: f64,
    /// Values above are cut off. Infinite: none.
    pub clip: f64,
}

/// Doublings of an exposure's first guess either way before the search gives up.
const MOST_DOUBLINGS: usize = 40;

impl Default for Tone {
    fn default() -> Self {
        Self {
            gamma: 1.0,
            knee: 0.0,
            clip: f64::INFINITY,
        }
    }
}

impl Tone {
    /// Whether values are proportional to light.
    pub fn is_linear(&self) -> bool {
        *self == Self::default()
    }

    /// The factor on `light` at which its pixel values sum to `sum`: the exposure at which a picture of that
    /// sum was taken. By bisection, values grow with light; where clipping keeps them all below, the
    /// largest factor tried. None where there is no light or no positive sum.
    pub fn exposure(&self, light: &[f64], sum: f64) -> Option<f64> {
        let total: f64 = light.iter().sum();
        let sound = |x: f64| x > 0.0 && x.is_finite();
        if !sound(sum) || !sound(total) {
            return None;
        }
        let seen = |factor: f64| light.iter().map(|l| self.apply(factor * l)).sum::<f64>();
        let (mut low, mut high) = (sum / total, sum / total);
        for _ in 0..MOST_DOUBLINGS {
            if seen(low) <= sum {
                break;
            }
            low /= 2.0;
        }
        for _ in 0..MOST_DOUBLINGS {
            if seen(high) >= sum {
                break;
            }
            high *= 2.0;
        }
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if seen(middle) < sum {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some((low + high) / 2.0)
    }

    /// The pixel value of linear light `l`. Negative light keeps its sign.
    pub fn apply(&self, l: f64) -> f64 {
        let g = if self.gamma == 1.0 {
            l.abs()
        } else {
            l.abs().powf(self.gamma)
        };
        let bent = g * (1.0 + self.knee) / (1.0 + self.knee * g).max(1e-9);
        bent.min(self.clip).copysign(l)
    }
}

impl Sensor {
    /// Whether the picture stays as the lens draws it; tone apart.
    pub fn is_ideal(&self) -> bool {
        !self.blurs() && self.halo.share == 0.0
    }

    /// Whether streak, box or copies blur the picture.
    pub fn blurs(&self) -> bool {
        [self.streak_px, self.box_px, self.copies_px] != [[0.0; 2]; 3]
    }

    /// How far streak, box and copies carry light along x and y, px.
    pub fn reach_px(&self) -> [f64; 2] {
        [0, 1].map(|axis| {
            (self.streak_px[axis].abs() + self.box_px[axis].abs() + self.copies_px[axis].abs())
                / 2.0
        })
    }

    /// The same sensor in px of which `scale` make up one of the present ones.
    #[must_use]
    pub fn rescaled(&self, scale: f64) -> Self {
        let by = |v: [f64; 2]| v.map(|x| x * scale);
        Self {
            streak_px: by(self.streak_px),
            box_px: by(self.box_px),
            copies_px: by(self.copies_px),
            halo: Halo {
                radius_px: self.halo.radius_px * scale,
                ..self.halo
            },
            tone: self.tone,
        }
    }

    /// The same sensor on a picture stretched along x by `factor`.
    #[must_use]
    pub fn stretched_x(&self, factor: f64) -> Self {
        let by = |[x, y]: [f64; 2]| [x * factor, y];
        Self {
            streak_px: by(self.streak_px),
            box_px: by(self.box_px),
            copies_px: by(self.copies_px),
            halo: Halo {
                stretch_x: self.halo.stretch_x * factor,
                ..self.halo
            },
            tone: self.tone,
        }
    }

    /// `moments` with what streak, box and copies add. A halo, whose variance need not exist, adds
    /// nothing.
    #[must_use]
    pub fn add_moments(&self, moments: CentralMoments) -> CentralMoments {
        let ([sx, sy], [bx, by], [cx, cy]) = (self.streak_px, self.box_px, self.copies_px);
        CentralMoments {
            mu20: moments.mu20 + (sx * sx + bx * bx) / 12.0 + cx * cx / 4.0,
            mu11: moments.mu11 + sx * sy / 12.0,
            mu02: moments.mu02 + (sy * sy + by * by) / 12.0 + cy * cy / 4.0,
            ..moments
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ideal_sensor_does_nothing() {
        let (sensor, tone) = (Sensor::default(), Tone::default());
        assert!(sensor.is_ideal() && tone.is_linear());
        for light in [-0.1, 0.0, 0.3, 1.0, 40.0] {
            assert_eq!(tone.apply(light), light);
        }
    }

    #[test]
    fn tone_keeps_white_and_bends_what_is_darker() {
        let tone = Tone {
            gamma: 0.8,
            knee: 0.5,
            clip: 0.9,
        };
        assert!((Tone { clip: 2.0, ..tone }.apply(1.0) - 1.0).abs() < 1e-12);
        assert!(
            tone.apply(0.2) > 0.2 && tone.apply(1.0) == 0.9 && tone.apply(-0.2) == -tone.apply(0.2)
        );
    }
    #[test]
    fn exposures_are_found_again() {
        let tone = Tone {
            gamma: 0.7,
            knee: 0.8,
            clip: 0.95,
        };
        let light = [0.5, 0.3, 0.1, 0.05, 0.05];
        for exposure in [0.01, 0.4, 1.5] {
            let sum = light.iter().map(|l| tone.apply(exposure * l)).sum();
            let found = tone.exposure(&light, sum).expect("light");
            assert!((found / exposure - 1.0).abs() < 1e-9, "{found} {exposure}");
        }
        assert!(tone.exposure(&light, 0.0).is_none());
        assert!(tone.exposure(&light, 10.0).is_some_and(f64::is_finite));
    }

    #[test]
    fn a_halo_reaches_where_its_share_is_left() {
        let halo = Halo {
            share: 0.2,
            radius_px: 3.0,
            steepness: 2.5,
            ..Halo::default()
        };
        let radius = halo.radius_holding(0.005);
        let beyond = halo.share * (1.0 + radius * radius / 9.0).powf(-1.5);
        assert!((beyond - 0.005).abs() < 1e-12);
        assert_eq!(Halo::default().radius_holding(0.005), 0.0);
    }
}
