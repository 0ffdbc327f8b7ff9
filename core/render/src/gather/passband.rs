//! Compensation of the attenuation by the pyramid's low-pass filters.
//!
//! Downsampling to level L and upsampling again multiplies a wave of u cycles per pixel of the level by
//! T(u) = product over j = 1..L of H(u / 2^j)^2, H being the pyramid's low-pass. The compensation filter is convolved
//! with the level's kernels, so it costs nothing per pixel. Its response is
//! C(u) = 1 + sum over k of c_k (2 cos(2 pi k u) - 2), which is 1 at u = 0. The c_k minimise the squares of
//! G(u) (C(u) T(u) - 1) / (u + 0.03), G being the narrowest Gaussian drawn at the level; low frequencies weigh more
//! because pictures consist mostly of them.

use super::pyramid::response;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::{Mutex, PoisonError};

/// Taps on either side of the middle tap.
pub(super) const SIDE_TAPS: usize = 4;

/// Frequencies of the fit, from 0 to half a cycle per pixel.
const FREQUENCIES: usize = 128;

/// Frequency below which the weights of the fit level off, cycles per pixel.
const WEIGHT_CORNER: f64 = 0.03;

/// The middle tap of a filter and the taps to one side.
pub(super) type Filter = [f64; SIDE_TAPS + 1];

/// Most filters that are kept.
const MOST_FILTERS: usize = 4096;

/// Filters kept from one render to the next: every crop of every depth layer asks for the same few, and a fit takes 0.1 ms.
#[derive(Default)]
pub(super) struct FilterStore(Mutex<BTreeMap<(u32, u64), Filter>>);

impl FilterStore {
    /// Returns the [`compensation_filter`].
    pub(super) fn filter(&self, level: u32, sigma: f64) -> Filter {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (level, sigma.to_bits());
        if known.len() == MOST_FILTERS && !known.contains_key(&key) {
            known.clear();
        }
        *(known.entry(key)).or_insert_with(|| compensation_filter(level, sigma))
    }
}

/// Returns the filter for kernels of at least `sigma` pixels of `level`.
///
/// At level 0 it is the identity.
pub(super) fn compensation_filter(level: u32, sigma: f64) -> Filter {
    let mut filter = [0.0; SIDE_TAPS + 1];
    filter[0] = 1.0;
    if level == 0 {
        return filter;
    }
    let wave = |k: usize, u: f64| 2.0 * (TAU * k as f64 * u).cos() - 2.0;
    let frequency = |row: usize| (row as f64 + 0.5) / (2 * FREQUENCIES) as f64;
    let attenuation = |row: usize| -> f64 {
        let fine = |j: u32| frequency(row) / f64::from(1_u32 << j);
        (1..=level).map(|j| response(fine(j)).powi(2)).product()
    };
    let attenuation: Vec<f64> = (0..FREQUENCIES).map(attenuation).collect();
    let weight = |u: f64| (-0.5 * (TAU * sigma * u).powi(2)).exp() / (u + WEIGHT_CORNER);
    let matrix = DMatrix::from_fn(FREQUENCIES, SIDE_TAPS, |row, k| {
        let u = frequency(row);
        weight(u) * attenuation[row] * wave(k + 1, u)
    });
    let missing = DVector::from_fn(FREQUENCIES, |row, _| {
        let u = frequency(row);
        weight(u) * (1.0 - attenuation[row])
    });
    if let Ok(found) = matrix.svd(true, true).solve(&missing, 1e-9) {
        for k in 0..SIDE_TAPS {
            filter[k + 1] = found[k];
            filter[0] -= 2.0 * found[k];
        }
    }
    filter
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gather::image::{Image, Rect};
    use crate::gather::pyramid::{UpsampleBuffers, downsample, upsample_tile};

    fn convolved(image: &Image, filter: &[f64]) -> Image {
        let mut across = Image::zeros(image.rect());
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

    /// Downsampling, compensation and upsampling keep the waves that wide kernels pass.
    #[test]
    fn smooth_pictures_survive_the_pyramid() {
        let wave = |x: f64, y: f64| 1.0 + (0.21 * x + 0.4).sin() * (0.17 * y).cos();
        let mut fine = Image::zeros(Rect {
            left: 0,
            top: 0,
            width: 96,
            height: 80,
        });
        for (k, sample) in fine.samples.iter_mut().enumerate() {
            *sample = wave((k % 96) as f64 + 0.5, (k / 96) as f64 + 0.5) as f32;
        }
        let worst = |coarse: &Image| {
            let mut out = vec![0.0; 16 * 16];
            upsample_tile(
                &coarse.view(),
                40,
                32,
                16,
                &mut UpsampleBuffers::default(),
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
        let coarse = downsample(&fine.view());
        let (without, with) = (
            worst(&coarse),
            worst(&convolved(&coarse, &compensation_filter(1, 1.15))),
        );
        assert!(with < 1e-3 && without > 10.0 * with, "{with} {without}");
    }
}
