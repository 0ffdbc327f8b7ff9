//! What halving and doubling take from waves that a coarse level still carries, and the filter that
//! gives it back: it is laid over the level's kernels, so that it costs nothing per pixel.
//!
//! Between the plate and level L and back a wave of u cycles per pixel of the level is left with
//! T(u) = product over j = 1..L of H(u / 2^j)^2, H being the low-pass of the pyramid. The filter is
//! C(u) = 1 + sum over k of c_k (2 cos(2 pi k u) - 2), an even plate left as it is, with the least squares
//! of G(u) (C(u) T(u) - 1) / (u + 0.03), G being the narrowest Gaussian drawn at the level; slow waves
//! count more, as pictures are made of them.

use super::pyramid::response;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Taps of the filter on either side of its middle.
pub(super) const SIDE: usize = 4;

/// Frequencies at which the filter is fitted, from 0 to half a cycle per pixel.
const FREQUENCIES: usize = 128;

/// Cycles per pixel below which waves are held to be as strong as each other.
const SLOWEST: f64 = 0.03;

/// The filter's middle tap and those to one side, for kernels of at least `sigma` pixels of `level`.
pub(super) fn filter(level: u32, sigma: f64) -> [f64; SIDE + 1] {
    let mut filter = [0.0; SIDE + 1];
    filter[0] = 1.0;
    if level == 0 {
        return filter;
    }
    let wave = |k: usize, u: f64| 2.0 * (TAU * k as f64 * u).cos() - 2.0;
    let frequency = |row: usize| (row as f64 + 0.5) / (2 * FREQUENCIES) as f64;
    let left = |u: f64| -> f64 {
        let passes = (1..=level).map(|j| response(u / f64::from(1_u32 << j)).powi(2));
        passes.product()
    };
    let drawn = |u: f64| (-0.5 * (TAU * sigma * u).powi(2)).exp() / (u + SLOWEST);
    let matrix = DMatrix::from_fn(FREQUENCIES, SIDE, |row, k| {
        let u = frequency(row);
        drawn(u) * left(u) * wave(k + 1, u)
    });
    let missing = DVector::from_fn(FREQUENCIES, |row, _| {
        let u = frequency(row);
        drawn(u) * (1.0 - left(u))
    });
    if let Ok(found) = matrix.svd(true, true).solve(&missing, 1e-9) {
        for k in 0..SIDE {
            filter[k + 1] = found[k];
            filter[0] -= 2.0 * found[k];
        }
    }
    filter
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::image::Image;
    use crate::gather::pyramid::{Doubling, doubled, halved};

    fn laid_over(image: &Image, filter: &[f64]) -> Image {
        let mut across = Image::zeros((image.left, image.top), (image.width, image.height));
        let mut both = across.clone();
        let reach = filter.len() as i32 - 1;
        let tap = |k: i32| filter[k.unsigned_abs() as usize] as f32;
        let at = |image: &Image, x: i32, y: i32| {
            let inside =
                (0..image.width as i32).contains(&x) && (0..image.height as i32).contains(&y);
            if inside {
                image.samples[y as usize * image.width + x as usize]
            } else {
                0.0
            }
        };
        for slot in 0..across.samples.len() {
            let (x, y) = ((slot % image.width) as i32, (slot / image.width) as i32);
            across.samples[slot] = (-reach..=reach).map(|k| tap(k) * at(image, x + k, y)).sum();
        }
        for slot in 0..both.samples.len() {
            let (x, y) = ((slot % image.width) as i32, (slot / image.width) as i32);
            both.samples[slot] = (-reach..=reach)
                .map(|k| tap(k) * at(&across, x, y + k))
                .sum();
        }
        both
    }

    /// Down, filtered and up again leaves waves that wide kernels leave as they are, in place.
    #[test]
    fn smooth_pictures_come_back() {
        let wave = |x: f64, y: f64| 1.0 + (0.21 * x + 0.4).sin() * (0.17 * y).cos();
        let mut fine = Image::zeros((0, 0), (96, 80));
        for (k, sample) in fine.samples.iter_mut().enumerate() {
            *sample = wave((k % 96) as f64 + 0.5, (k / 96) as f64 + 0.5) as f32;
        }
        let worst = |coarse: &Image| {
            let mut out = vec![0.0; 16 * 16];
            doubled(
                &coarse.view(),
                (40, 32),
                16,
                &mut Doubling::default(),
                &mut out,
            );
            out.iter()
                .enumerate()
                .map(|(k, found)| {
                    let wanted = wave((40 + k % 16) as f64 + 0.5, (32 + k / 16) as f64 + 0.5);
                    (f64::from(*found) - wanted).abs()
                })
                .fold(0.0, f64::max)
        };
        let coarse = halved(&fine.view());
        let (without, with) = (worst(&coarse), worst(&laid_over(&coarse, &filter(1, 1.15))));
        assert!(with < 1e-3 && without > 10.0 * with, "{with} {without}");
    }
}
