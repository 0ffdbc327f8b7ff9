//! A tile: the samples of one PSF on a small pixel grid.

use crate::error::{Error, Result};

/// Samples of one channel of one PSF, row-major from the top-left pixel, scene-linear.
///
/// Tile coordinates: (0, 0) is the outer corner of the top-left pixel, pixel centres at halves.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    width: usize,
    height: usize,
    samples: Vec<f32>,
}

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

    #[test]
    fn invalid_tiles_are_rejected_with_the_sample_position() {
        assert!(Tile::new(2, 2, vec![0.0; 3]).is_err());
        assert!(Tile::new(0, 0, vec![]).is_err());
        let error = Tile::new(2, 2, vec![0.0, 1.0, 2.0, f32::NAN]).expect_err("NaN");
        assert!(error.problem.contains("column 1, row 1"), "{error}");
    }
}
