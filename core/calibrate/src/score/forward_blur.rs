//! Forward-blur signal-to-noise ratio M_FB of the paper (Eq 45).
//!
//! M_FB = 10 log10( Var[P * Z] / mean((P * Z - Q * Z)²) ) for the true kernel P, its approximation Q and an
//! image Z. Z is extended by mirroring to twice its width and height and taken as periodic, so borders have
//! no influence; its mean is removed. Then for any kernel K
//!
//! V(K) = mean((K * Z)²) = sum over lags d of R_K(d) A(d)
//!
//! with the autocorrelations R_K of K and A of Z (Wiener-Khinchin), and M_FB = 10 log10(V(P) / V(P - Q)).
//! This is exact, and costs one small transform per kernel instead of a convolution.
//!
//! The choice of image changes the figures more than the choice of method does (1 to 6 dB between two
//! photographs in the reference study). Compare only figures of the same image.

use seidel_fourier::{Complex, fast_length};

use super::TestImage;
use super::spectrum::Transform;

/// Largest ratio V(P) / V(P - Q) reported: 300 dB.
const MAX_POWER_RATIO: f64 = 1e30;

/// Autocorrelation of a mirrored, periodic test image. Made once and used for every kernel size.
pub struct ImageAutocorrelation {
    width: usize,
    height: usize,
    /// Row-major, lag (0, 0) first; the half plane of x lags 0..=width / 2.
    values: Vec<f64>,
}

impl ImageAutocorrelation {
    /// Computes the autocorrelation of `image`, mirrored to twice its size, without its mean.
    pub fn new(image: &TestImage) -> Self {
        let (w, h) = (image.width(), image.height());
        let (width, height) = (2 * w, 2 * h);
        let mean = image.samples().iter().sum::<f64>() / image.samples().len() as f64;
        let mut mirrored = Vec::with_capacity(width * height);
        for y in 0..height {
            let row = &image.samples()[y.min(height - 1 - y) * w..][..w];
            mirrored.extend(row.iter().map(|v| v - mean));
            mirrored.extend(row.iter().rev().map(|v| v - mean));
        }
        let transform = Transform::new(width, height);
        let spectrum = transform.apply(&mirrored, width);
        // The power spectrum is real and even, so a forward transform serves as the inverse. Entry (kx, ky)
        // of the other half plane equals (-kx, -ky).
        let mut power = vec![0.0; width * height];
        for ky in 0..height {
            for kx in 0..width {
                power[ky * width + kx] = if kx < transform.columns() {
                    spectrum[kx * height + ky].norm_sqr()
                } else {
                    spectrum[(width - kx) * height + (height - ky) % height].norm_sqr()
                };
            }
        }
        let count = (width * height) as f64;
        let values = transform
            .apply(&power, width)
            .iter()
            .map(|v| v.re / (count * count))
            .collect();
        Self {
            width,
            height,
            values,
        }
    }

    /// Returns the mean over the image of Z(x) Z(x + d) at lag d = (`dx`, `dy`) px.
    fn at(&self, dx: i64, dy: i64) -> f64 {
        let mut x = dx.rem_euclid(self.width as i64) as usize;
        let mut y = dy.rem_euclid(self.height as i64) as usize;
        if x > self.width / 2 {
            x = self.width - x;
            y = (self.height - y) % self.height;
        }
        self.values[x * self.height + y]
    }

    /// Returns a scorer of kernels on squares of `side` px.
    pub fn scorer(&self, side: usize) -> BlurScorer {
        let size = fast_length(2 * side);
        let transform = Transform::new(size, size);
        let mut lags = vec![0.0; size * size];
        let most = side as i64 - 1;
        let wrapped = |d: i64| d.rem_euclid(size as i64) as usize;
        for dy in -most..=most {
            for dx in -most..=most {
                lags[wrapped(dy) * size + wrapped(dx)] = self.at(dx, dy);
            }
        }
        let scale = 1.0 / (size * size) as f64;
        let spectrum = transform.apply(&lags, size);
        let weights = spectrum
            .chunks_exact(size)
            .enumerate()
            .flat_map(|(kx, column)| {
                let scale = scale * transform.multiplicity(kx);
                column.iter().map(move |v| scale * v.re)
            })
            .collect();
        BlurScorer {
            side,
            transform,
            weights,
        }
    }
}

/// Forward-blur SNR of kernels of one size under one image.
pub struct BlurScorer {
    side: usize,
    transform: Transform,
    /// Contribution of each entry of a kernel's power spectrum to V.
    weights: Vec<f64>,
}

impl BlurScorer {
    /// Returns the side of the kernels, px.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Returns V(K), the mean square of the image convolved with `kernel` (row-major, [`BlurScorer::side`]²
    /// samples).
    ///
    /// # Panics
    /// If `kernel` has another number of samples.
    pub fn blurred_power(&self, kernel: &[f64]) -> f64 {
        assert_eq!(kernel.len(), self.side * self.side, "one sample a pixel");
        let spectrum = self.transform.apply(kernel, self.side);
        spectrum
            .iter()
            .zip(&self.weights)
            .map(|(value, weight): (&Complex<f64>, _)| weight * value.norm_sqr())
            .sum()
    }

    /// Returns M_FB in dB of `approximation` for `reference`, whose V(P) is `reference_power`; at most 300
    /// dB.
    ///
    /// # Panics
    /// If either kernel does not have [`BlurScorer::side`]² samples.
    pub fn snr_db(&self, reference: &[f64], reference_power: f64, approximation: &[f64]) -> f64 {
        assert_eq!(reference.len(), approximation.len(), "kernels of one size");
        let difference: Vec<f64> = reference
            .iter()
            .zip(approximation)
            .map(|(p, q)| p - q)
            .collect();
        let error = self.blurred_power(&difference);
        10.0 * (reference_power / error.max(reference_power / MAX_POWER_RATIO)).log10()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    /// Mean square of the mirrored, periodic, zero-mean image convolved with `kernel`, by direct summation.
    fn by_convolution(image: &TestImage, kernel: &[f64], side: usize) -> f64 {
        let (w, h) = (image.width(), image.height());
        let mean = image.samples().iter().sum::<f64>() / (w * h) as f64;
        let z = |x: i64, y: i64| {
            let fold = |k: i64, n: usize| {
                let k = k.rem_euclid(2 * n as i64) as usize;
                k.min(2 * n - 1 - k)
            };
            image.samples()[fold(y, h) * w + fold(x, w)] - mean
        };
        let mut sum = 0.0;
        for y in 0..2 * h as i64 {
            for x in 0..2 * w as i64 {
                let blurred: f64 = kernel
                    .iter()
                    .enumerate()
                    .map(|(k, v)| v * z(x - (k % side) as i64, y - (k / side) as i64))
                    .sum();
                sum += blurred * blurred;
            }
        }
        sum / (4 * w * h) as f64
    }

    #[test]
    fn the_fast_form_equals_convolution() {
        let mut random = SplitMix64::new(3);
        // Kernels smaller and larger than the mirrored image.
        for (width, height, side) in [(7, 6, 3), (5, 8, 4), (3, 4, 11)] {
            let samples = (0..width * height).map(|_| random.unit()).collect();
            let image = TestImage::new(width, height, samples).expect("valid");
            let scorer = ImageAutocorrelation::new(&image).scorer(side);
            let kernel = |random: &mut SplitMix64| -> Vec<f64> {
                (0..side * side).map(|_| random.unit() - 0.3).collect()
            };
            let (p, q) = (kernel(&mut random), kernel(&mut random));
            let difference: Vec<f64> = p.iter().zip(&q).map(|(p, q)| p - q).collect();
            let signal = by_convolution(&image, &p, side);
            let error = by_convolution(&image, &difference, side);
            let got = scorer.blurred_power(&p);
            assert!((got / signal - 1.0).abs() < 1e-9, "{got} {signal}");
            let got = scorer.snr_db(&p, got, &q);
            let want = 10.0 * (signal / error).log10();
            assert!((got - want).abs() < 1e-9, "{got} {want}");
        }
    }

    #[test]
    fn an_exact_match_is_finite() {
        let image = TestImage::new(2, 2, vec![0.0, 1.0, 2.0, 5.0]).expect("valid");
        let scorer = ImageAutocorrelation::new(&image).scorer(1);
        let square = scorer.blurred_power(&[1.0]);
        assert!((scorer.snr_db(&[1.0], square, &[1.0]) - 300.0).abs() < 1e-9);
    }
}
