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
}

impl Halo {
    /// The radius beyond which it carries no more than `share` of all light, px.
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

    /// The pixel value of linear light `l`. Negative light keeps its sign.
    pub fn of(&self, l: f64) -> f64 {
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

    /// `moments` with what streak, box and copies add. A halo, whose variance need not exist, adds
    /// nothing.
    #[must_use]
    pub fn widened(&self, moments: CentralMoments) -> CentralMoments {
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
            assert_eq!(tone.of(light), light);
        }
    }

    #[test]
    fn tone_keeps_white_and_bends_what_is_darker() {
        let tone = Tone {
            gamma: 0.8,
            knee: 0.5,
            clip: 0.9,
        };
        assert!((Tone { clip: 2.0, ..tone }.of(1.0) - 1.0).abs() < 1e-12);
        assert!(tone.of(0.2) > 0.2 && tone.of(1.0) == 0.9 && tone.of(-0.2) == -tone.of(0.2));
    }
}
