//! A tile: the samples of one PSF on a small pixel grid.

use crate::error::{Error, Result};
use crate::numeric::median;

/// Samples of one channel of one PSF, row-major from the top-left pixel, scene-linear.
///
/// Tile coordinates: (0, 0) is the outer corner of the top-left pixel, pixel centres at halves.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    width: usize,
    height: usize,
    samples: Vec<f32>,
}

/// Width of the rim of [`Tile::rim_noise`], pixels.
const RIM_PX: usize = 3;

impl Tile {
    /// Creates a tile of `width` x `height` samples, row-major.
    ///
    /// # Errors
    /// Rejects a zero size, a sample count other than `width` x `height`, and samples that are not finite.
    pub fn new(width: usize, height: usize, samples: Vec<f32>) -> Result<Self> {
        if width == 0 || height == 0 || width.checked_mul(height) != Some(samples.len()) {
            return Err(Error::new(
                "tile",
                format!(
                    "has {} samples for {width} x {height} pixels",
                    samples.len()
                ),
                "give one sample a pixel",
            ));
        }
        if let Some(bad) = samples.iter().position(|s| !s.is_finite()) {
            return Err(Error::new(
                "tile",
                format!(
                    "the sample at column {}, row {} is {}",
                    bad % width,
                    bad / width,
                    samples[bad]
                ),
                "replace it with a finite value or leave the tile out",
            ));
        }
        Ok(Self {
            width,
            height,
            samples,
        })
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The samples, row-major.
    pub fn samples(&self) -> &[f32] {
        &self.samples
    }

    /// Returns the sum of all samples.
    pub fn sum(&self) -> f64 {
        self.samples.iter().map(|&s| f64::from(s)).sum()
    }

    /// Estimates the standard deviation of pixel noise by the median absolute difference of neighbours along the rim, which
    /// holds little light. Zero for tiles of a single pixel.
    pub fn rim_noise(&self) -> f64 {
        let (width, height) = (self.width(), self.height());
        let mut differences = Vec::new();
        let mut push = |a: usize, b: usize| {
            differences.push((f64::from(self.samples[a]) - f64::from(self.samples[b])).abs());
        };
        for ring in 0..RIM_PX.min(width.min(height) / 2) {
            for row in [ring, height - 1 - ring] {
                for column in 0..width - 1 {
                    push(row * width + column, row * width + column + 1);
                }
            }
            for column in [ring, width - 1 - ring] {
                for row in 0..height - 1 {
                    push(row * width + column, (row + 1) * width + column);
                }
            }
        }
        // The median of |x| of a standard normal distribution is 0.6745; a difference has twice the variance.
        median(&mut differences) / (0.674_49 * std::f64::consts::SQRT_2)
    }

    /// Returns the tile with `background` subtracted from every sample.
    #[must_use]
    pub fn minus_background(&self, background: f64) -> Self {
        Self {
            samples: self
                .samples
                .iter()
                .map(|&s| (f64::from(s) - background) as f32)
                .collect(),
            ..*self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::SplitMix64;

    #[test]
    fn invalid_tiles_are_rejected_with_the_sample_position() {
        assert!(Tile::new(2, 2, vec![0.0; 3]).is_err());
        assert!(Tile::new(0, 0, vec![]).is_err());
        let error = Tile::new(2, 2, vec![0.0, 1.0, 2.0, f32::NAN]).expect_err("NaN");
        assert!(error.problem.contains("column 1, row 1"), "{error}");
    }

    #[test]
    fn noise_is_estimated_at_the_rim() {
        let mut random = SplitMix64::new(5);
        let mut tile = |sigma: f64| {
            // A bright square in the middle, and noise: the sum of twelve uniform numbers has unit variance.
            let samples = (0..40 * 40).map(|k: usize| {
                let inside = |v: usize| (15..25).contains(&v);
                let light = f64::from(u8::from(inside(k % 40) && inside(k / 40)));
                let noise: f64 = (0..12).map(|_| random.unit() - 0.5).sum();
                (light + sigma * noise) as f32
            });
            Tile::new(40, 40, samples.collect()).expect("a tile")
        };
        let estimated = tile(0.05).rim_noise();
        assert!((0.042..0.058).contains(&estimated), "{estimated}");
        assert_eq!(tile(0.0).rim_noise(), 0.0);
        let dot = Tile::new(1, 1, vec![1.0]).expect("a tile");
        assert_eq!(dot.rim_noise(), 0.0);
    }
}
