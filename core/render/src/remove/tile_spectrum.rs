//! The power spectrum of a tile, and how well a transfer function explains it.
//!
//! Under a window, the spectrum of a plate blurred by the transfer function h has the mean power
//!
//! ```text
//! S(f) = P(f) G(f) + N,    G = (w * (|h|² Q)) / Q
//! ```
//!
//! | symbol | meaning |
//! | --- | --- |
//! | P | the power of the sharp picture: the exponential of a polynomial in ln \|f\|, of \|f\|², and of waves in the direction of f |
//! | Q | a power law, f^-2.5: what the window spreads comes from low frequencies |
//! | w | the power of the window's own spectrum |
//! | N | the power of the noise |
//!
//! Each power I of the tile is about S times an exponential deviate, so that minus twice its log likelihood, up to a constant, is
//! 2 (I/S - 1 - ln(I/S)) (P. Whittle, "Estimation and information in stationary time series", 1953). The sum is the deviance. P fits
//! any smooth change of the spectrum, so that zeros and lobes of h decide, and not what the picture is.

use super::tile_fft::{FftBuffers, TileFft};
use nalgebra::{SMatrix, SVector};
use seidel_fourier::Complex;
use std::f64::consts::PI;

/// Number of terms of ln P.
const TERMS: usize = 7;
/// Least frequency that counts, in those of a wave as long as the tile: the window mixes lower ones.
const MIN_WAVES: f64 = 3.5;
/// Exponent of Q, as of most pictures.
const POWER_LAW: f64 = -2.5;
/// Frequencies that are averaged for an estimate of the noise, and the rank of the noise among such averages.
const NOISE_CELL: usize = 24;
const NOISE_QUANTILE: f64 = 0.1;
/// Least standard deviation of the noise, as a share of the tile's mean: kernels are right to no more than that.
const MODEL_ERROR: f64 = 3e-3;
/// Least ratio of the mean power to that of the noise: tiles with less show no detail.
const MIN_DETAIL: f64 = 20.0;
/// Largest number of steps of the fit, trials of one step with growing damping, the damping at the start, and the largest change of a
/// term in a step.
const STEPS: usize = 25;
const TRIALS: usize = 8;
const DAMPING: f64 = 1e-2;
const MAX_STEP: f64 = 3.0;
/// Relative decrease of the deviance that ends a fit.
const SETTLED: f64 = 1e-4;

type Terms = SVector<f64, TERMS>;
type Hessian = SMatrix<f64, TERMS, TERMS>;

/// The frequencies of square tiles of one side, and the terms of ln P there.
pub(super) struct TileFrequencies {
    fft: TileFft,
    /// The window along one axis, whose energy over the tile is one.
    window: Vec<f32>,
    /// Its circular autocorrelation along one axis, one at the origin.
    correlation: Vec<f32>,
    /// Q over the whole spectrum, column by column.
    power_law: Vec<f32>,
    /// Indices of the frequencies that count.
    used: Vec<usize>,
    /// The terms at each of them.
    terms: Vec<Terms>,
}

impl TileFrequencies {
    pub(super) fn new(side: usize) -> Self {
        let fft = TileFft::new(side);
        let sine = |k: usize| (PI * (k as f64 + 0.5) / side as f64).sin().powi(2);
        let energy: f64 = (0..side).map(|k| sine(k).powi(2)).sum();
        let window: Vec<f64> = (0..side).map(|k| sine(k) / energy.sqrt()).collect();
        let correlation = |shift: usize| {
            let products = (0..side).map(|k| window[k] * window[(k + shift) % side]);
            products.sum::<f64>() as f32
        };
        let frequency = |k: usize| {
            let wrapped = if 2 * k > side {
                k as f64 - side as f64
            } else {
                k as f64
            };
            wrapped / side as f64
        };
        let (mut power_law, mut used, mut terms) = (Vec::new(), Vec::new(), Vec::new());
        for column in 0..fft.column_count() {
            for row in 0..side {
                let (x, y) = (frequency(column), frequency(row));
                let (radius, angle) = (x.hypot(y), y.atan2(x));
                let bounded = radius.hypot(1.0 / side as f64);
                power_law.push(if radius > 0.0 {
                    bounded.powf(POWER_LAW) as f32
                } else {
                    0.0
                });
                // The other half of these columns holds the same powers.
                let is_repeated = (column == 0 || 2 * column == side) && 2 * row > side;
                if radius * side as f64 > MIN_WAVES && radius <= 0.5 && !is_repeated {
                    let l = (radius / 0.15).ln();
                    used.push(column * side + row);
                    terms.push(Terms::from([
                        1.0,
                        l,
                        l * l,
                        (radius / 0.25).powi(2),
                        (2.0 * angle).cos(),
                        (2.0 * angle).sin(),
                        (4.0 * angle).cos(),
                    ]));
                }
            }
        }
        Self {
            correlation: (0..side).map(correlation).collect(),
            window: window.iter().map(|v| *v as f32).collect(),
            fft,
            power_law,
            used,
            terms,
        }
    }

    pub(super) fn fft(&self) -> &TileFft {
        &self.fft
    }

    /// Returns the number of frequencies that count.
    pub(super) fn count(&self) -> usize {
        self.used.len()
    }

    /// Returns the power spectrum of a tile of `samples`, or `None` if it has little but noise.
    pub(super) fn spectrum(&self, samples: &[f32]) -> Option<TileSpectrum> {
        let side = self.fft.side;
        let window = |k: usize| self.window[k % side] * self.window[k / side];
        let weighted = |k: usize| f64::from(samples[k] * window(k).powi(2));
        let mean = (0..samples.len()).map(weighted).sum::<f64>();
        let mut tile: Vec<f32> = (0..samples.len())
            .map(|k| (samples[k] - mean as f32) * window(k))
            .collect();
        let mut buffers = FftBuffers::default();
        self.fft.forward(&mut tile, &mut buffers);
        let power = |k: &usize| f64::from(buffers.spectrum[*k].norm_sqr());
        let powers: Vec<f64> = self.used.iter().map(power).collect();
        let average = |powers: &[f64]| powers.iter().sum::<f64>() / powers.len() as f64;
        let mut cells: Vec<f64> = powers.chunks_exact(NOISE_CELL).map(average).collect();
        let rank = (NOISE_QUANTILE * cells.len() as f64) as usize;
        let (_, quiet, _) = cells.select_nth_unstable_by(rank, f64::total_cmp);
        let noise = quiet
            .max((MODEL_ERROR * mean).powi(2))
            .max(f64::MIN_POSITIVE);
        (average(&powers) > MIN_DETAIL * noise).then_some(TileSpectrum { powers, noise })
    }

    /// Returns G of a transfer function, at the frequencies that count.
    fn spread_power(&self, transfer: &[Complex<f32>]) -> Vec<f64> {
        let side = self.fft.side;
        let mut buffers = FftBuffers::default();
        let power = transfer.iter().zip(&self.power_law);
        buffers.spectrum = power
            .map(|(h, q)| Complex::new(h.norm_sqr() * q, 0.0))
            .collect();
        let mut tile = vec![0.0; side * side];
        self.fft.inverse(&mut buffers, &mut tile);
        for (k, value) in tile.iter_mut().enumerate() {
            *value *= self.correlation[k % side] * self.correlation[k / side];
        }
        self.fft.forward(&mut tile, &mut buffers);
        let spread = |k: &usize| f64::from(buffers.spectrum[*k].re / self.power_law[*k]);
        self.used.iter().map(|k| spread(k).max(1e-12)).collect()
    }
}

/// The powers of a tile at the frequencies that count.
pub(super) struct TileSpectrum {
    powers: Vec<f64>,
    /// N.
    noise: f64,
}

impl TileSpectrum {
    /// Returns the least deviance of the spectrum for a lens with the transfer function `transfer`, over all P. The fit is that of
    /// Levenberg and Marquardt.
    pub(super) fn deviance(&self, at: &TileFrequencies, transfer: &[Complex<f32>]) -> f64 {
        let spread = at.spread_power(transfer);
        let blurred_picture = |c: &Terms| -> Vec<f64> {
            let power = |terms: &Terms| terms.dot(c).clamp(-60.0, 40.0).exp();
            let frequencies = at.terms.iter().zip(&spread);
            frequencies.map(|(terms, g)| power(terms) * g).collect()
        };
        let ratios = self.powers.iter().zip(&spread);
        let ratios = ratios.map(|(i, g)| i / g.max(0.05));
        let mut c = Terms::zeros();
        c[0] = (ratios.sum::<f64>() / self.powers.len() as f64).ln();
        c[1] = POWER_LAW;
        let mut picture = blurred_picture(&c);
        let (mut least, mut damping) = (self.deviance_from(&picture), DAMPING);
        for _ in 0..STEPS {
            let (hessian, gradient) = self.normal_equations(at, &picture);
            let better = (0..TRIALS).find_map(|_| {
                let trial = c + damped_step(&hessian, &gradient, damping)?;
                let picture = blurred_picture(&trial);
                let deviance = self.deviance_from(&picture);
                let is_better = deviance < least;
                damping = if is_better {
                    (damping / 5.0).max(1e-6)
                } else {
                    5.0 * damping
                };
                is_better.then_some((trial, picture, deviance))
            });
            let Some(better) = better else {
                break;
            };
            let before = least;
            (c, picture, least) = better;
            if before - least < SETTLED * before {
                break;
            }
        }
        least
    }

    /// Returns the deviance from the mean powers `picture` + N.
    fn deviance_from(&self, picture: &[f64]) -> f64 {
        let frequencies = self.powers.iter().zip(picture);
        let ratios = frequencies.map(|(i, p)| i / (p + self.noise));
        let terms = ratios.map(|ratio| 2.0 * (ratio - 1.0 - ratio.max(1e-30).ln()));
        terms.sum()
    }

    /// Returns the expected Hessian of half the deviance over the terms of ln P, and its negative gradient.
    fn normal_equations(&self, at: &TileFrequencies, picture: &[f64]) -> (Hessian, Terms) {
        let (mut hessian, mut gradient) = (Hessian::zeros(), Terms::zeros());
        for ((i, p), terms) in self.powers.iter().zip(picture).zip(&at.terms) {
            let s = p + self.noise;
            let weighted = terms * (p / s);
            gradient += weighted * (i / s - 1.0);
            hessian.ger(1.0, &weighted, &weighted, 1.0);
        }
        (hessian, gradient)
    }
}

/// Returns the step that the damped normal equations give, or `None` if rounding has left them singular.
fn damped_step(hessian: &Hessian, gradient: &Terms, damping: f64) -> Option<Terms> {
    let mut damped = *hessian;
    for k in 0..TERMS {
        damped[(k, k)] += damping * (hessian[(k, k)] + 1e-9);
    }
    let step = damped.cholesky()?.solve(gradient);
    Some(step.map(|v| v.clamp(-MAX_STEP, MAX_STEP)))
}

#[cfg(test)]
mod tests {
    use super::super::test_scenes::NormalDeviates;
    use super::*;
    use crate::LocalKernel;

    const SIDE: usize = 96;

    fn disc(radius: f64) -> LocalKernel {
        let reach = radius.ceil() as i32 + 1;
        let width = (2 * reach + 1) as usize;
        let offset =
            |k: usize, sub: i32| f64::from(k as i32 - reach) + (f64::from(sub) - 3.5) / 8.0;
        let weight = |k: usize| {
            let inside = |sub: i32| {
                let (x, y) = (offset(k % width, sub % 8), offset(k / width, sub / 8));
                x.hypot(y) <= radius
            };
            (0..64).filter(|sub| inside(*sub)).count() as f32
        };
        let weights: Vec<f32> = (0..width * width).map(weight).collect();
        let sum: f32 = weights.iter().sum();
        LocalKernel {
            left: -reach,
            top: -reach,
            width,
            height: width,
            weights: weights.iter().map(|weight| weight / sum).collect(),
        }
    }

    /// Squares at random places, blurred by `kernel`, with noise.
    fn blurred_squares(kernel: &LocalKernel) -> Vec<f32> {
        let mut deviates = NormalDeviates(5);
        let mut sharp = vec![0.4_f32; SIDE * SIDE];
        for _ in 0..60 {
            let mut place = || (deviates.next().abs() * 1e4) as usize % (SIDE - 8);
            let (x, y) = (place(), place());
            let level = 0.4 + 0.2 * deviates.next() as f32;
            for k in 0..64 {
                sharp[(y + k / 8) * SIDE + x + k % 8] = level;
            }
        }
        let wrap = |at: i32| at.rem_euclid(SIDE as i32) as usize;
        let sample = |k: usize| {
            let terms = kernel.weights.iter().enumerate().map(|(j, weight)| {
                let x = (k % SIDE) as i32 - kernel.left - (j % kernel.width) as i32;
                let y = (k / SIDE) as i32 - kernel.top - (j / kernel.width) as i32;
                weight * sharp[wrap(y) * SIDE + wrap(x)]
            });
            terms.sum::<f32>() + 0.001 * deviates.next() as f32
        };
        (0..SIDE * SIDE).map(sample).collect()
    }

    #[test]
    fn the_deviance_is_least_for_the_disc_that_blurred_the_tile() {
        let at = TileFrequencies::new(SIDE);
        for radius in [2.0, 5.0, 9.0] {
            let samples = blurred_squares(&disc(radius));
            let spectrum = at.spectrum(&samples).expect("detail");
            let deviance = |share: f64| {
                let transfer = at
                    .fft()
                    .transfer_function(&disc(share * radius), (SIDE, SIDE));
                spectrum.deviance(&at, &transfer)
            };
            let own = deviance(1.0);
            for share in [0.6, 0.8, 1.25, 1.5] {
                assert!(
                    deviance(share) > own * 1.02,
                    "{radius} {share}: {} {own}",
                    deviance(share)
                );
            }
        }
    }

    #[test]
    fn noise_alone_has_no_detail() {
        let mut deviates = NormalDeviates(9);
        let noise: Vec<f32> = (0..SIDE * SIDE)
            .map(|_| 0.4 + 0.01 * deviates.next() as f32)
            .collect();
        assert!(TileFrequencies::new(SIDE).spectrum(&noise).is_none());
    }
}
