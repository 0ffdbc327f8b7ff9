//! Test image Z of the forward-blur score, read or synthetic.

use seidel_optics::error::{Error, Result};
use seidel_optics::numeric::SplitMix64;

/// A scene-linear grey image.
#[derive(Debug, Clone, PartialEq)]
pub struct TestImage {
    width: usize,
    height: usize,
    samples: Vec<f64>,
}

/// Side of the synthetic image, px.
const SIDE: usize = 512;
/// Subsamples per pixel side, averaged as a sensor averages.
const OVERSAMPLING: usize = 2;
/// Smallest and largest radius of the discs, px.
const RADII_PX: [f64; 2] = [1.0, 160.0];
/// Seed of [`TestImage::natural`].
const SEED: u64 = 2014;

impl TestImage {
    /// Creates an image of `width` x `height` samples, row-major from the top-left pixel.
    ///
    /// # Errors
    /// A zero size, another number of samples, non-finite samples, or a uniform image.
    pub fn new(width: usize, height: usize, samples: Vec<f64>) -> Result<Self> {
        let bad = |problem: String, remedy: &str| Err(Error::new("test image", problem, remedy));
        if width == 0 || height == 0 || width.checked_mul(height) != Some(samples.len()) {
            return bad(
                format!(
                    "has {} samples for {width} x {height} pixels",
                    samples.len()
                ),
                "give one sample a pixel",
            );
        }
        if let Some(index) = samples.iter().position(|s| !s.is_finite()) {
            return bad(
                format!(
                    "the sample at column {}, row {} is {}",
                    index % width,
                    index / width,
                    samples[index]
                ),
                "give a picture of finite values",
            );
        }
        if samples.iter().all(|s| *s == samples[0]) {
            return bad(
                "is uniform, so blur has no effect on it".into(),
                "give a picture with detail",
            );
        }
        Ok(Self {
            width,
            height,
            samples,
        })
    }

    /// Returns a synthetic image of 512 x 512 px with natural statistics, identical on every machine.
    ///
    /// The dead-leaves model (Matheron 1968; Lee, Mumford and Huang 2001): opaque discs of uniform grey are
    /// dropped until the plane is covered. The number of radii r falls as r^-3, which makes the image
    /// scale-invariant. Its amplitude spectrum falls about as 1 / frequency, as that of photographs does.
    pub fn natural() -> Self {
        Self::dead_leaves(SEED)
    }

    fn dead_leaves(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let fine = SIDE * OVERSAMPLING;
        let [least, largest] = RADII_PX.map(|r| r * OVERSAMPLING as f64);
        let (near, far) = (1.0 / (least * least), 1.0 / (largest * largest));
        // Front to back: a sample keeps the first disc that covers it. Only additions, products and roots are
        // used, which every machine rounds alike.
        let mut plane = vec![f64::NAN; fine * fine];
        let mut left = plane.len();
        while left > 0 {
            let (x, y) = (random.unit() * fine as f64, random.unit() * fine as f64);
            let radius = 1.0 / (near - random.unit() * (near - far)).sqrt();
            let grey = random.unit();
            let rows = (y - radius).ceil() as i64..=(y + radius).floor() as i64;
            for row in rows {
                let dy = row as f64 - y;
                let half = (radius * radius - dy * dy).max(0.0).sqrt();
                let line = row.rem_euclid(fine as i64) as usize * fine;
                for column in (x - half).ceil() as i64..=(x + half).floor() as i64 {
                    let sample = &mut plane[line + column.rem_euclid(fine as i64) as usize];
                    if sample.is_nan() {
                        *sample = grey;
                        left -= 1;
                    }
                }
            }
        }
        let samples = (0..SIDE * SIDE)
            .map(|k| {
                let (x, y) = (k % SIDE * OVERSAMPLING, k / SIDE * OVERSAMPLING);
                let sum: f64 = (0..OVERSAMPLING)
                    .flat_map(|row| &plane[(y + row) * fine + x..][..OVERSAMPLING])
                    .sum();
                sum / (OVERSAMPLING * OVERSAMPLING) as f64
            })
            .collect();
        Self {
            width: SIDE,
            height: SIDE,
            samples,
        }
    }

    /// Returns the width, px.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the height, px.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns the samples, row-major.
    pub fn samples(&self) -> &[f64] {
        &self.samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::spectrum::Transform;

    /// Exponent of the amplitude spectrum: slope of log amplitude (root mean power of a ring a third of an
    /// octave wide) against log frequency from 4 to 128 cycles per image.
    fn slope(image: &TestImage) -> f64 {
        let (w, h) = (image.width(), image.height());
        let mean = image.samples().iter().sum::<f64>() / (w * h) as f64;
        // A Hann window suppresses the discontinuity at the border.
        let hann = |k: usize, n: usize| {
            0.5 - 0.5 * (std::f64::consts::TAU * (k as f64 + 0.5) / n as f64).cos()
        };
        let windowed: Vec<f64> = image
            .samples()
            .iter()
            .enumerate()
            .map(|(k, v)| (v - mean) * hann(k % w, w) * hann(k / w, h))
            .collect();
        let spectrum = Transform::new(w, h).apply(&windowed, w);
        let rings = 15;
        let mut power = vec![(0.0, 0.0); rings];
        for kx in 0..=w / 2 {
            for ky in 0..h {
                let f = (kx as f64).hypot(ky.min(h - ky) as f64);
                let ring = ((f / 4.0).log2() * 3.0).floor();
                if ring >= 0.0 && (ring as usize) < rings {
                    let entry = &mut power[ring as usize];
                    entry.0 += spectrum[kx * h + ky].norm_sqr();
                    entry.1 += 1.0;
                }
            }
        }
        let points: Vec<(f64, f64)> = power
            .iter()
            .enumerate()
            .map(|(k, (sum, count))| {
                let f: f64 = 4.0 * ((k as f64 + 0.5) / 3.0).exp2();
                (f.ln(), 0.5 * (sum / count).ln())
            })
            .collect();
        let n = points.len() as f64;
        let (mx, my) = (
            points.iter().map(|p| p.0).sum::<f64>() / n,
            points.iter().map(|p| p.1).sum::<f64>() / n,
        );
        points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>()
            / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
    }

    #[test]
    fn the_synthetic_image_has_a_natural_spectrum() {
        let got = slope(&TestImage::natural());
        assert!((got + 1.0).abs() < 0.25, "amplitude ~ f^{got}");
    }

    #[test]
    fn the_synthetic_image_is_covered_and_reproducible() {
        let image = TestImage::natural();
        assert!(image.samples().iter().all(|v| (0.0..1.0).contains(v)));
        assert_eq!(image, TestImage::natural());
        assert_ne!(image, TestImage::dead_leaves(SEED + 1));
    }

    #[test]
    fn invalid_images_are_rejected() {
        assert!(TestImage::new(2, 2, vec![0.0; 3]).is_err());
        assert!(TestImage::new(0, 0, vec![]).is_err());
        assert!(TestImage::new(2, 1, vec![0.5; 2]).is_err());
        assert!(TestImage::new(2, 1, vec![0.5, f64::NAN]).is_err());
    }
}
