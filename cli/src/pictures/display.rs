//! The display transform of scene-linear plates: exposure, a filmic shoulder, sRGB.

use image::{Rgb, RgbImage};
use seidel_core::{Error, Result};

/// A scene-linear RGB plate, planes row-major from the top-left pixel.
#[derive(Debug, Clone, Copy)]
pub struct LinearRgb<'a> {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// R, G and B.
    pub planes: [&'a [f32]; 3],
}

/// A transform from scene-linear light to display codes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DisplayTransform {
    /// Exposure change, stops; applied first.
    pub exposure_stops: f32,
    /// Whether highlights roll off instead of clipping at 1.
    pub filmic: bool,
}

impl Default for DisplayTransform {
    fn default() -> Self {
        Self {
            exposure_stops: 0.0,
            filmic: true,
        }
    }
}

/// Display-linear value at which the shoulder starts.
const SHOULDER_FROM: f32 = 0.55;

impl DisplayTransform {
    /// Returns the plate as an 8-bit sRGB image.
    ///
    /// # Errors
    /// Planes without one value per pixel, and an empty plate.
    pub fn image(&self, plate: &LinearRgb<'_>) -> Result<RgbImage> {
        let (width, height) = plate.checked_size()?;
        Ok(RgbImage::from_fn(width, height, |x, y| {
            let index = y as usize * plate.width + x as usize;
            Rgb(self.codes(plate.planes.map(|p| p[index])))
        }))
    }

    /// Returns the sRGB codes (0 to 255) of a scene-linear colour; negative light is black.
    pub fn codes(&self, linear: [f32; 3]) -> [u8; 3] {
        let exposed = linear.map(|v| (v * self.exposure_stops.exp2()).max(0.0));
        if !self.filmic {
            return exposed.map(|v| encode(v.min(1.0)));
        }
        // The mean of a shoulder per channel and one common shoulder by the brightest channel: the
        // first alone turns every lamp white, the second alone turns orange to salmon.
        let peak = exposed.iter().fold(f32::MIN_POSITIVE, |a, &b| a.max(b));
        let kept = shoulder(peak) / peak;
        exposed.map(|v| encode(0.5 * (shoulder(v) + kept * v)))
    }
}

/// Returns a smooth curve, the identity up to [`SHOULDER_FROM`] and then approaching 1.
fn shoulder(value: f32) -> f32 {
    let over = value - SHOULDER_FROM;
    if over <= 0.0 {
        return value;
    }
    let room = 1.0 - SHOULDER_FROM;
    SHOULDER_FROM + room * over / (over + room)
}

/// Returns the sRGB code (IEC 61966-2-1) of a display-linear value in 0..1.
fn encode(linear: f32) -> u8 {
    let encoded = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    (encoded * 255.0).round() as u8
}

impl LinearRgb<'_> {
    /// Returns the checked width and height.
    ///
    /// # Errors
    /// An empty plate, and planes of another size.
    pub(super) fn checked_size(&self) -> Result<(u32, u32)> {
        let pixels = self.width.checked_mul(self.height);
        let size = u32::try_from(self.width)
            .ok()
            .zip(u32::try_from(self.height).ok());
        match size {
            Some((width, height))
                if width > 0
                    && height > 0
                    && self.planes.iter().all(|p| Some(p.len()) == pixels) =>
            {
                Ok((width, height))
            }
            _ => Err(Error::new(
                "plate",
                format!(
                    "has {} values per channel for {} x {} pixels",
                    self.planes[0].len(),
                    self.width,
                    self.height
                ),
                "give one value per pixel and channel",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_rise_to_white_without_a_step() {
        let transform = DisplayTransform::default();
        let mut last = 0;
        for step in 0..4000 {
            let [code, ..] = transform.codes([step as f32 / 1000.0; 3]);
            assert!(
                code >= last && code - last <= 13,
                "{step}: {last} to {code}"
            );
            last = code;
        }
        assert_eq!(transform.codes([900.0; 3]), [255; 3]);
        assert_eq!(transform.codes([-1.0; 3]), [0; 3]);
        let mid = transform.codes([0.18; 3]);
        assert_eq!(mid, [118; 3], "sRGB below the shoulder");
    }

    #[test]
    fn bright_lights_keep_their_hue() {
        let [r, g, b] = DisplayTransform::default().codes([8.0, 3.0, 0.5]);
        assert!(r > g && g > b, "{r} {g} {b}");
        let stop_up = DisplayTransform {
            exposure_stops: 1.0,
            filmic: false,
        };
        assert_eq!(stop_up.codes([0.5, 0.6, 0.0]), [255, 255, 0]);
    }

    #[test]
    fn a_plate_of_the_wrong_size_is_rejected() {
        let short = [0.0; 5];
        let plate = LinearRgb {
            width: 2,
            height: 3,
            planes: [&short; 3],
        };
        assert!(DisplayTransform::default().image(&plate).is_err());
    }
}
