//! How alike two blurs make a picture: forward-blur signal to noise (M_FB of the paper, Eq 45).
//!
//! M_FB = 10 log10( Var[P * Z] / mean((P * Z - Q * Z)²) ) for the true kernel P, its stand-in Q and a
//! picture Z. Z is mirrored to twice its width and height and taken as periodic, so that no border
//! enters, and its mean is removed. Then for any kernel K
//!
//!   V(K) = mean((K * Z)²) = sum over lags d of R_K(d) A(d)
//!
//! with R_K and A the autocorrelations of K and of Z, and M_FB = 10 log10(V(P) / V(P - Q)): exact, and
//! at the cost of one small transform a kernel instead of a convolution.
//!
//! The picture decides the figures more than the methods do (the reference study saw 1 to 6 dB between
//! two photographs): compare only like with like.

use realfft::num_complex::Complex;

use super::TestImage;
use super::spectrum::{Transform, quick_length};

/// V(P) / V(P - Q) is not told apart from an exact match beyond this ratio: 10 log10 of it is 300 dB.
const EXACT: f64 = 1e30;

/// The autocorrelation of a test image, mirrored and periodic: made once, used for every kernel size.
pub struct ImageCorrelation {
    width: usize,
    height: usize,
    /// Row-major, lag (0, 0) first; every column of the half plane of x lags 0..=width / 2.
    values: Vec<f64>,
}

impl ImageCorrelation {
    /// Of `image`, mirrored to twice its size, its mean removed.
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
        // The power spectrum is real and even, so transforming it forth is as good as back. It is laid
        // out whole; entry (kx, ky) of the other half plane equals (-kx, -ky).
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

    /// Mean over the picture of Z(x) Z(x + d), lag d = (`dx`, `dy`) px.
    fn at(&self, dx: i64, dy: i64) -> f64 {
        let mut x = dx.rem_euclid(self.width as i64) as usize;
        let mut y = dy.rem_euclid(self.height as i64) as usize;
        if x > self.width / 2 {
            x = self.width - x;
            y = (self.height - y) % self.height;
        }
        self.values[x * self.height + y]
    }

    /// A scorer of kernels drawn on squares of `side` px.
    pub fn scorer(&self, side: usize) -> BlurScorer {
        let size = quick_length(2 * side);
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

/// M_FB of kernels on squares of one size under one picture.
pub struct BlurScorer {
    side: usize,
    transform: Transform,
    /// What each entry of a kernel's power spectrum adds to V.
    weights: Vec<f64>,
}

impl BlurScorer {
    /// Side of the squares on which kernels are given, px.
    pub fn side(&self) -> usize {
        self.side
    }

    /// V(K): mean square of the picture convolved with `kernel` (row-major, [`BlurScorer::side`]
    /// squared samples).
    ///
    /// # Panics
    /// If `kernel` has another number of samples.
    pub fn mean_square(&self, kernel: &[f64]) -> f64 {
        assert_eq!(kernel.len(), self.side * self.side, "one sample a pixel");
        let spectrum = self.transform.apply(kernel, self.side);
        spectrum
            .iter()
            .zip(&self.weights)
            .map(|(value, weight): (&Complex<f64>, _)| weight * value.norm_sqr())
            .sum()
    }

    /// M_FB in dB of `stand_in` for `truth`, whose V(P) is `truth_square`; 300 dB at most.
    ///
    /// # Panics
    /// If either kernel is not of [`BlurScorer::side`] squared samples.
    pub fn decibels(&self, truth: &[f64], truth_square: f64, stand_in: &[f64]) -> f64 {
        assert_eq!(truth.len(), stand_in.len(), "kernels of one size");
        let difference: Vec<f64> = truth.iter().zip(stand_in).map(|(p, q)| p - q).collect();
        let error = self.mean_square(&difference);
        10.0 * (truth_square / error.max(truth_square / EXACT)).log10()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    /// Mean square of the mirrored, periodic, zero-mean picture convolved with `kernel`, by the sums
    /// of the definition.
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
        // Kernels smaller and larger than the mirrored picture.
        for (width, height, side) in [(7, 6, 3), (5, 8, 4), (3, 4, 11)] {
            let samples = (0..width * height).map(|_| random.unit()).collect();
            let image = TestImage::new(width, height, samples).expect("valid");
            let scorer = ImageCorrelation::new(&image).scorer(side);
            let kernel = |random: &mut SplitMix64| -> Vec<f64> {
                (0..side * side).map(|_| random.unit() - 0.3).collect()
            };
            let (p, q) = (kernel(&mut random), kernel(&mut random));
            let difference: Vec<f64> = p.iter().zip(&q).map(|(p, q)| p - q).collect();
            let signal = by_convolution(&image, &p, side);
            let error = by_convolution(&image, &difference, side);
            let got = scorer.mean_square(&p);
            assert!((got / signal - 1.0).abs() < 1e-9, "{got} {signal}");
            let got = scorer.decibels(&p, got, &q);
            let want = 10.0 * (signal / error).log10();
            assert!((got - want).abs() < 1e-9, "{got} {want}");
        }
    }

    #[test]
    fn an_exact_match_is_finite() {
        let image = TestImage::new(2, 2, vec![0.0, 1.0, 2.0, 5.0]).expect("valid");
        let scorer = ImageCorrelation::new(&image).scorer(1);
        let square = scorer.mean_square(&[1.0]);
        assert!((scorer.decibels(&[1.0], square, &[1.0]) - 300.0).abs() < 1e-9);
    }
}
