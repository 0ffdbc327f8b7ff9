//! Noise of plates, the same on every machine.

use crate::SIDE;
use std::f64::consts::TAU;

/// Light at which film grain has the deviation asked for.
const MIDDLE_GREY: f32 = 0.18;

/// The kind of noise that a plate gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Noise {
    /// Gaussian, each pixel by itself, the same at all levels.
    White,
    /// Film grain: Gaussian, shared by neighbouring pixels (a binomial kernel of 3 x 3 px), with a deviation that grows
    /// with the square root of the light.
    FilmGrain,
}

impl Noise {
    /// Adds noise to a plate; its standard deviation is `deviation`, for film grain at middle grey.
    pub(crate) fn add_to(self, samples: &[f32], deviation: f64, seed: u64) -> Vec<f32> {
        let white = normal_deviates(samples.len(), seed);
        let noisy = samples.iter().enumerate();
        match self {
            Self::White => noisy
                .map(|(k, sample)| sample + (deviation * white[k]) as f32)
                .collect(),
            Self::FilmGrain => {
                let grain = clumped(&white);
                noisy
                    .map(|(k, sample)| {
                        let level = (sample.max(0.0) / MIDDLE_GREY).sqrt();
                        sample + (deviation * grain[k]) as f32 * level
                    })
                    .collect()
            }
        }
    }
}

/// Returns independent standard normal deviates (a linear congruential generator and Box-Muller).
fn normal_deviates(count: usize, seed: u64) -> Vec<f64> {
    let mut state = 12345_u64 + seed;
    let mut uniform = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as f64 + 0.5) / (1_u64 << 31) as f64
    };
    (0..count)
        .map(|_| (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos())
        .collect()
}

/// Filters white noise by 1, 2, 1 along both axes, edges wrapped, and restores its variance.
fn clumped(white: &[f64]) -> Vec<f64> {
    let wrapped = |v: usize, by: usize| (v + by) % SIDE;
    // The sum of squares of 1, 2, 1 is 6, along each axis.
    let scale = 1.0 / 6.0;
    (0..white.len())
        .map(|k| {
            let (x, y) = (k % SIDE, k / SIDE);
            let row = |y: usize| {
                let at = |x: usize| white[y * SIDE + x];
                at(wrapped(x, SIDE - 1)) + 2.0 * at(x) + at(wrapped(x, 1))
            };
            scale * (row(wrapped(y, SIDE - 1)) + 2.0 * row(y) + row(wrapped(y, 1)))
        })
        .collect()
}
