//! The sensor model: shift-invariant blur and a tone curve, applied to the image that the lens forms.
//!
//! In this order: motion blur ([`Sensor::streak_px`]); an optical low-pass filter ([`Sensor::copies_px`]) and a
//! pixel aperture larger than the pixel ([`Sensor::box_px`]); scattered light ([`Halo`]); the tone curve
//! ([`Tone`]). All but the tone curve are linear and conserve energy.

use std::f64::consts::LN_2;

use crate::moments::CentralMoments;

/// A sensor, lengths in px. The default is the ideal sensor, which changes nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensor {
    /// Motion of the image during the exposure (x, y), at constant speed. The path is centred on the position at
    /// rest.
    pub streak_px: [f64; 2],
    /// Sides (x, y) of an extra box blur, besides integration over the pixel itself.
    pub box_px: [f64; 2],
    /// Distances along x and y between the four copies that a birefringent low-pass filter makes.
    pub copies_px: [f64; 2],
    /// Scattered light.
    pub halo: Halo,
    /// Pixel value as a function of light.
    pub tone: Tone,
}

/// Scattered light: a Moffat profile, with density proportional to `(1 + r²/radius²)^-steepness`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Halo {
    /// Share of the light, 0 to 1.
    pub share: f64,
    /// Radius, px.
    pub radius_px: f64,
    /// Exponent of the profile, above one; the larger, the closer to a Gaussian.
    pub steepness: f64,
    /// Stretch along x; differs from one on pixels that are not square.
    pub stretch_x: f64,
}

impl Halo {
    /// Returns the radius along y, px, beyond which the halo holds no more than `share` of all light.
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

/// A tone curve: a power law with a shoulder, `l^gamma (1 + knee) / (1 + knee l^gamma)`, then clipping.
///
/// White is one, and stays one unless clipped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Exponent; below one brightens dark values.
    pub gamma: f64,
    /// Compression of bright values, above -1; negative values expand them.
    pub knee: f64,
    /// Largest value; infinite for no clipping.
    pub clip: f64,
}

/// Most doublings of the first guess of an exposure, in either direction, before the search starts, and most steps of it.
const MOST_DOUBLINGS: usize = 40;
const MOST_SECANTS: usize = 60;
/// Relative error of an exposure or of its sum at which the search stops.
const EXPOSURE_TOLERANCE: f64 = 1e-13;

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
    /// Returns whether pixel values equal light.
    pub fn is_linear(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the factor on `light` at which its pixel values sum to `sum`: the exposure of an image with that sum.
    ///
    /// Found by the Illinois method in the logarithm of the factor, as values grow with light. If clipping keeps every sum
    /// below `sum`, returns the largest factor tried. `None` if there is no light or `sum` is not positive.
    pub fn exposure(&self, light: &[f64], sum: f64) -> Option<f64> {
        let total: f64 = light.iter().sum();
        let sound = |x: f64| x > 0.0 && x.is_finite();
        if !sound(sum) || !sound(total) {
            return None;
        }
        // Powers of products are products of powers, and powers take most of the time.
        let powers: Vec<f64> = light.iter().map(|l| self.power(*l)).collect();
        let excess = |log: f64| {
            let factor = self.power(log.exp());
            let recorded = powers.iter().map(|power| self.compress(factor * power));
            recorded.sum::<f64>() / sum - 1.0
        };
        let start = (sum / total).ln();
        let (mut low, mut below) = (start, excess(start));
        let (mut high, mut above) = (low, below);
        for _ in 0..MOST_DOUBLINGS {
            if below <= 0.0 {
                break;
            }
            low -= LN_2;
            below = excess(low);
        }
        for _ in 0..MOST_DOUBLINGS {
            if above >= 0.0 {
                break;
            }
            high += LN_2;
            above = excess(high);
        }
        if above < 0.0 {
            return Some(high.exp());
        }
        let mut last_side = 0.0;
        for _ in 0..MOST_SECANTS {
            if high - low < EXPOSURE_TOLERANCE || above - below <= 0.0 {
                break;
            }
            let middle = (low * above - high * below) / (above - below);
            let here = excess(middle);
            if here == 0.0 {
                return Some(middle.exp());
            }
            // An end that stays twice loses half its weight, so that both ends close in.
            let stays = here.signum() == last_side;
            last_side = here.signum();
            if here < 0.0 {
                (low, below) = (middle, here);
                above *= if stays { 0.5 } else { 1.0 };
            } else {
                (high, above) = (middle, here);
                below *= if stays { 0.5 } else { 1.0 };
            }
            if here.abs() < EXPOSURE_TOLERANCE {
                return Some(middle.exp());
            }
        }
        Some(((low + high) / 2.0).exp())
    }

    /// Returns the pixel value of linear light `l`. Negative light keeps its sign.
    pub fn apply(&self, l: f64) -> f64 {
        self.compress(self.power(l))
    }

    /// Returns the derivative of [`Tone::apply`] at light `l`; zero where values are clipped.
    pub fn slope(&self, l: f64) -> f64 {
        if l == 0.0 || self.apply(l).abs() >= self.clip {
            return 0.0;
        }
        let g = self.power(l).abs();
        let rest = (1.0 + self.knee * g).max(1e-9);
        (1.0 + self.knee) / (rest * rest) * self.gamma * g / l.abs()
    }

    /// Returns `l` to the power gamma, with its sign.
    fn power(&self, l: f64) -> f64 {
        if self.gamma == 1.0 {
            l
        } else {
            l.abs().powf(self.gamma).copysign(l)
        }
    }

    /// Returns the pixel value of `power`, light to the power gamma with its sign.
    fn compress(&self, power: f64) -> f64 {
        let g = power.abs();
        let value = g * (1.0 + self.knee) / (1.0 + self.knee * g).max(1e-9);
        value.min(self.clip).copysign(power)
    }
}

impl Sensor {
    /// Returns whether the sensor leaves light unchanged, apart from the tone curve.
    pub fn is_ideal(&self) -> bool {
        !self.blurs() && self.halo.share == 0.0
    }

    /// Returns whether streak, box or copies blur the image.
    pub fn blurs(&self) -> bool {
        [self.streak_px, self.box_px, self.copies_px] != [[0.0; 2]; 3]
    }

    /// Returns how far streak, box and copies carry light along x and y, px.
    pub fn blur_radius_px(&self) -> [f64; 2] {
        [0, 1].map(|axis| {
            (self.streak_px[axis].abs() + self.box_px[axis].abs() + self.copies_px[axis].abs())
                / 2.0
        })
    }

    /// Returns a sensor that blurs at least as widely as both and scatters light where either does.
    #[must_use]
    pub fn widest(&self, other: &Self) -> Self {
        let larger = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|k| a[k].abs().max(b[k].abs()));
        let halo = if other.halo.share > self.halo.share {
            other.halo
        } else {
            self.halo
        };
        Self {
            streak_px: larger(self.streak_px, other.streak_px),
            box_px: larger(self.box_px, other.box_px),
            copies_px: larger(self.copies_px, other.copies_px),
            halo,
            tone: self.tone,
        }
    }

    /// Returns the sensor on a grid with `scale` times as many pixels along each axis.
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

    /// Returns the sensor for an image stretched along x by `factor`.
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

    /// Returns `moments` with the variance of streak, box and copies added. A halo adds nothing: its variance may
    /// not exist.
    #[must_use]
    pub fn blurred_moments(&self, moments: CentralMoments) -> CentralMoments {
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
    fn tone_keeps_white_and_changes_darker_values() {
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
    fn exposures_are_recovered() {
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
    fn slopes_are_those_of_the_curve() {
        let tone = Tone {
            gamma: 0.7,
            knee: 0.8,
            clip: 0.95,
        };
        for l in [0.01, 0.2, -0.3, 0.6] {
            let rate = (tone.apply(l + 1e-6) - tone.apply(l - 1e-6)) / 2e-6;
            assert!((tone.slope(l) / rate - 1.0).abs() < 1e-6, "{l}");
        }
        assert_eq!(tone.slope(0.99), 0.0, "clipped");
    }

    #[test]
    fn the_holding_radius_leaves_the_asked_share_outside() {
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
