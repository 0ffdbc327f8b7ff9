//! The transmission of a pupil as a picture.

use std::sync::Arc;

use crate::error::{Error, Result};

/// Side of the grid that holds a picture, over the square about the pupil.
const SIDE: usize = 64;
/// Least transmission: a PSF always has light.
const LEAST: f32 = 1e-6;

/// A picture of an aperture: its transmission over the square about the pupil. Clones share its samples, since pupils are
/// cloned for every point of a plate.
#[derive(Debug, Clone, PartialEq)]
pub struct AperturePicture {
    /// Row-major, `SIDE` rows of as many samples, the first at the top left.
    samples: Arc<[f32]>,
}

impl AperturePicture {
    /// Largest side of a picture, pixels.
    pub const MAX_SIDE: usize = 8192;

    /// Takes the transmission from `samples`, row-major with rows of `width`, each limited to 0 to 1. The square about the
    /// middle of the picture, with its shorter side, becomes that about the pupil.
    ///
    /// # Errors
    /// A number of samples that is no whole number of rows, a side of 0 or above [`AperturePicture::MAX_SIDE`], a sample that
    /// is not a number, and a picture that is black within the circle.
    pub fn new(width: usize, samples: &[f32]) -> Result<Self> {
        let sides = 1..=Self::MAX_SIDE;
        let height = samples.len().checked_div(width).unwrap_or(0);
        if width * height != samples.len() || !sides.contains(&width) || !sides.contains(&height) {
            return Err(Error::new(
                "aperture picture",
                format!("has {} samples in rows of {width}", samples.len()),
                format!(
                    "give whole rows, and sides of 1 to {} pixels",
                    Self::MAX_SIDE
                ),
            ));
        }
        if let Some(at) = samples.iter().position(|v| v.is_nan()) {
            return Err(Error::new(
                format!("aperture picture, pixel ({}, {})", at % width, at / width),
                "is not a number",
                "give transmissions of 0 to 1",
            ));
        }
        let grid = resampled(width, height, samples);
        let is_lit = |k: usize| {
            let [x, y] = [k % SIDE, k / SIDE].map(|i| 2.0 * (i as f64 + 0.5) / SIDE as f64 - 1.0);
            x.hypot(y) < 0.95 && grid[k] > 1e-3
        };
        if !(0..grid.len()).any(is_lit) {
            return Err(Error::new(
                "aperture picture",
                "is black within the circle of the aperture",
                "give a picture that is white where light passes",
            ));
        }
        Ok(Self {
            samples: grid.into(),
        })
    }

    /// Returns the samples of a picture of `count` pixels: the mean of its colours, 1 where it has none, times its alpha.
    pub fn transmission(count: usize, colours: &[&[f32]], alpha: Option<&[f32]>) -> Vec<f32> {
        let mut samples = vec![if colours.is_empty() { 1.0 } else { 0.0 }; count];
        let share = 1.0 / colours.len().max(1) as f32;
        for colour in colours {
            (samples.iter_mut().zip(*colour)).for_each(|(sum, v)| *sum += share * v);
        }
        let alpha = alpha.into_iter().flatten();
        (samples.iter_mut().zip(alpha)).for_each(|(sample, alpha)| *sample *= alpha);
        samples
    }

    /// Returns the transmission at pupil point `u`, with x to the right of the picture and y down.
    pub fn at(&self, u: [f64; 2]) -> f64 {
        let place = u.map(|u| {
            let at = ((u + 1.0) / 2.0 * SIDE as f64 - 0.5).clamp(0.0, (SIDE - 1) as f64);
            let first = (at as usize).min(SIDE - 2);
            (first, at - first as f64)
        });
        let [(column, right), (row, down)] = place;
        let of_row = |row: usize| {
            let from = row * SIDE + column;
            let [a, b] = [from, from + 1].map(|k| f64::from(self.samples[k]));
            a + right * (b - a)
        };
        let (above, below) = (of_row(row), of_row(row + 1));
        above + down * (below - above)
    }
}

/// Returns the mean of the picture over each cell of the grid, limited to [`LEAST`] to 1.
fn resampled(width: usize, height: usize, samples: &[f32]) -> Vec<f32> {
    let side = width.min(height) as f64;
    let origin = [width as f64 - side, height as f64 - side].map(|rest| rest / 2.0);
    let step = side / SIDE as f64;
    // Weights of the pixels that a cell covers, along one axis.
    let weights = |axis: usize, k: usize, count: usize| -> Vec<(usize, f64)> {
        let (from, to) = (
            origin[axis] + k as f64 * step,
            origin[axis] + (k + 1) as f64 * step,
        );
        let last = (to.ceil() as usize).min(count);
        (from as usize..last)
            .map(|pixel| {
                let (left, right) = (from.max(pixel as f64), to.min(pixel as f64 + 1.0));
                (pixel, (right - left).max(0.0) / step)
            })
            .collect()
    };
    let columns: Vec<_> = (0..SIDE).map(|k| weights(0, k, width)).collect();
    let mut grid = Vec::with_capacity(SIDE * SIDE);
    for k in 0..SIDE {
        let rows = weights(1, k, height);
        for column in &columns {
            let mut sum = 0.0;
            for (y, down) in &rows {
                for (x, across) in column {
                    let sample = samples[y * width + x].clamp(0.0, 1.0);
                    sum += down * across * f64::from(sample);
                }
            }
            grid.push((sum as f32).clamp(LEAST, 1.0));
        }
    }
    grid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_any_size_keep_their_shape() {
        for (width, height) in [(300, 300), (64, 64), (20, 50), (90, 31)] {
            // Light in the right half.
            let samples: Vec<f32> = (0..width * height)
                .map(|k| if 2 * (k % width) >= width { 0.8 } else { 0.0 })
                .collect();
            let picture = AperturePicture::new(width, &samples).expect("lit");
            for y in [-0.7, 0.0, 0.6] {
                assert!(
                    (picture.at([0.5, y]) - 0.8).abs() < 1e-6,
                    "{width} {height}"
                );
                assert!(picture.at([-0.5, y]) < 1e-5);
            }
            assert!(picture.at([7.0, -9.0]) > 0.7, "clamped");
        }
    }

    #[test]
    fn pictures_are_equal_by_their_samples() {
        let [first, again] = [1.0; 2].map(|v| AperturePicture::new(8, &[v; 64]).expect("lit"));
        assert_eq!(first, again);
        let other = AperturePicture::new(8, &[0.5; 64]).expect("lit");
        assert_ne!(first, other);
    }

    #[test]
    fn bad_pictures_are_refused() {
        for (width, samples, word) in [
            (3, vec![1.0; 8], "rows"),
            (0, vec![], "rows"),
            (2, vec![1.0, f32::NAN, 1.0, 1.0], "pixel (1, 0)"),
            (4, vec![0.0; 16], "black"),
        ] {
            let error = AperturePicture::new(width, &samples).expect_err("refused");
            assert!(error.to_string().contains(word), "{error}");
        }
    }
}
