//! PSF of one patch by regularised least squares, as a difference from the PSF expected of the lens.
//!
//! With S the convolution with the sharp picture, W the weights and e the plate less S p0, where p0 is the expected PSF, the
//! estimate p0 + d minimises
//!
//! ```text
//! (e - S d)' W (e - S d) + lambda |L d|²
//! ```
//!
//! with L the Laplacian. The regularisation pulls towards p0, not towards smoothness, so it adds no blur where nothing is
//! missing; otherwise [`TileResponse`] says which share of a difference it leaves. Lambda is the noise variance over the mean
//! square Laplacian of p0: a Wiener filter for differences as rough as the PSF itself. Noise is estimated from the residual.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};
use seidel_fourier::Complex;
use seidel_optics::numeric::{SplitMix64, dot};

use super::patch::Patch;
use super::response::{TileResponse, response_helix};
use crate::helix::Helix;

/// Iterations of estimating noise variance and difference.
const ROUNDS: usize = 2;
/// Conjugate-gradient steps per iteration, and the relative residual at which they stop.
const STEPS: usize = 60;
const TOLERANCE: f64 = 1e-4;
/// Lower bound of the noise relative to the light.
const LEAST_NOISE: f64 = 1e-6;
/// Share of noise energy in the expected tile's energy above which the patch is rejected.
const MOST_NOISE: f64 = 0.25;
/// Minimum number of valid pixels per pixel of the tile.
const LEAST_PIXELS: f64 = 2.0;
/// Minimum contrast of a patch.
const LEAST_CONTRAST: f64 = 1e-3;
/// Share of the plate's variance that the expected plate must explain.
const LEAST_EXPLAINED: f64 = 0.1;

/// Planned transforms for tiles of one side.
#[derive(Debug)]
pub(super) struct Plans {
    /// For windows with their margins.
    pub(super) window: Helix,
    /// For tiles.
    tile: Arc<Helix>,
    pub(super) side: usize,
    /// Squared response of the Laplacian at the frequencies of `tile`.
    rough: Vec<f64>,
}

impl Plans {
    /// Plans transforms for tiles of side `side` in squares of side `square`.
    pub(super) fn new(side: usize, square: usize) -> Self {
        let tile = response_helix(side);
        Self {
            window: Helix::new(square, square),
            side,
            rough: tile.laplacian_power(),
            tile: Arc::new(tile),
        }
    }
}

/// The lens's prediction for a patch, and what is known of its noise.
#[derive(Debug)]
pub(super) struct Expectation {
    /// The PSF at the centre of the texture, of unit sum.
    pub(super) tile: Vec<f64>,
    /// The plate, laid out like [`Patch::plate`].
    pub(super) plate: Vec<f64>,
    /// Noise variance that the plate has at least, as that of its quantisation.
    pub(super) least_variance: f64,
    /// Variance of the quantisation of the sharp picture.
    pub(super) sharp_variance: f64,
}

/// An estimated PSF.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    /// Samples, row-major.
    pub(super) tile: Vec<f64>,
    /// Standard deviation of the noise of a sample.
    pub(super) sigma: f64,
    pub(super) response: TileResponse,
    /// Energy of a simulated noise through the estimator, relative to the circulant approximation.
    pub(super) noise_ratio: Option<f64>,
}

/// A check of the noise of the estimate by simulated noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NoiseCheck {
    /// Noise of this seed is passed through the estimator.
    Simulated(u64),
    /// The circulant approximation alone.
    Skipped,
}

/// Estimates the PSF that maps the sharp picture to the plate; `None` where the patch does not determine it.
pub(super) fn estimate(
    plans: &Plans,
    patch: &Patch,
    expected: &Expectation,
    check: NoiseCheck,
) -> Option<Estimate> {
    let pixels = patch.pixels();
    let unknowns = (plans.side * plans.side) as f64;
    if pixels < LEAST_PIXELS * unknowns || patch.contrast() < LEAST_CONTRAST {
        return None;
    }
    let gain = Gain::fit(patch, &expected.plate, plans.window.stride)?;
    let difference: Vec<f64> = (0..patch.plate.len())
        .map(|k| {
            let share = gain.at(k, plans.window.stride);
            if patch.weight[k] > 0.0 {
                patch.plate[k] / share - expected.plate[k]
            } else {
                0.0
            }
        })
        .collect();
    let mean_square = patch.plate_mean(|v| v * v) / gain.middle().powi(2);
    let energy: f64 = expected.tile.iter().map(|v| v * v).sum();
    let known_variance =
        expected.least_variance / gain.middle().powi(2) + expected.sharp_variance * energy;
    let least = (LEAST_NOISE * LEAST_NOISE * mean_square)
        .max(known_variance)
        .max(f64::MIN_POSITIVE);
    let problem = Problem::new(plans, patch);
    let mut target = problem.correlate_weighted(&difference);
    // Noise of the sharp picture is correlated with itself in the normal matrix (errors in variables).
    for (value, light) in target.iter_mut().zip(&expected.tile) {
        *value += pixels * expected.sharp_variance * light;
    }
    let rough: f64 = laplacian(&expected.tile, plans.side)
        .iter()
        .map(|v| v * v)
        .sum();
    let mut tile = vec![0.0; plans.side * plans.side];
    let mut noise = (patch.weighted(|k| difference[k].powi(2)) / pixels).max(least);
    let mut lambda = problem.lambda(noise, rough);
    for _ in 0..ROUNDS {
        problem.solve(&mut tile, &target, lambda);
        let misfit = problem.misfit(&difference, &tile);
        let freedom = problem.residual_freedom(lambda);
        noise = (misfit / freedom.max(0.1 * pixels)).max(least);
        lambda = problem.lambda(noise, rough);
    }
    problem.solve(&mut tile, &target, lambda);
    let spectrum = problem.noise_spectrum(lambda);
    let variance = noise * problem.mean(&spectrum);
    let is_determined = unknowns * variance < MOST_NOISE * energy && variance.is_finite();
    if !is_determined {
        return None;
    }
    for (value, light) in tile.iter_mut().zip(&expected.tile) {
        *value += light;
    }
    let noise_ratio = match check {
        NoiseCheck::Skipped => None,
        NoiseCheck::Simulated(seed) => {
            Some(problem.simulated_energy(lambda, seed) / (unknowns * problem.mean(&spectrum)))
        }
    };
    let squares: Vec<f64> = spectrum.iter().map(|v| v * v).collect();
    let freedom = unknowns * problem.mean(&spectrum).powi(2) / problem.mean(&squares);
    Some(Estimate {
        tile,
        sigma: variance.sqrt(),
        response: TileResponse {
            helix: Arc::clone(&plans.tile),
            side: plans.side,
            expected: expected.tile.clone(),
            transfer: problem.transfer(lambda),
            noise_freedom: freedom.max(1.0),
        },
        noise_ratio,
    })
}

/// Exposure of the plate relative to the expected one: a plane over the window, for the falloff of light.
struct Gain {
    /// Value in the middle, and its change per column and row.
    plane: Vector3<f64>,
    middle: f64,
}

impl Gain {
    /// Fits the plane; `None` where the expected plate does not explain the patch.
    fn fit(patch: &Patch, expected: &[f64], stride: usize) -> Option<Self> {
        let middle = stride as f64 / 2.0;
        let mut matrix = Matrix3::zeros();
        let mut right = Vector3::zeros();
        for (k, weight) in patch.weight.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            let row = coordinates(k, stride, middle) * expected[k];
            matrix += *weight * row * row.transpose();
            right += *weight * patch.plate[k] * row;
        }
        let plane = matrix.lu().solve(&right)?;
        let gain = Self { plane, middle };
        let mean = patch.plate_mean(|v| v);
        let variance = patch.plate_mean(|v| (v - mean).powi(2));
        let left = patch.weighted(|k| (patch.plate[k] - gain.at(k, stride) * expected[k]).powi(2))
            / patch.pixels();
        let is_explained = left <= (1.0 - LEAST_EXPLAINED) * variance;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
        let is_positive = corners
            .iter()
            .all(|(x, y)| gain.plane.dot(&Vector3::new(1.0, *x, *y)) > 0.0);
        (is_explained && is_positive).then_some(gain)
    }

    fn at(&self, index: usize, stride: usize) -> f64 {
        self.plane.dot(&coordinates(index, stride, self.middle))
    }

    fn middle(&self) -> f64 {
        self.plane[0]
    }
}

/// Returns the weighted squared difference between a patch and an `expected` plate, with the exposure fitted; infinity where it
/// explains nothing.
pub(super) fn misfit(patch: &Patch, expected: &[f64], stride: usize) -> f64 {
    Gain::fit(patch, expected, stride).map_or(f64::INFINITY, |gain| {
        patch.weighted(|k| (patch.plate[k] - gain.at(k, stride) * expected[k]).powi(2))
    })
}

/// Returns 1 and the position of pixel `index`, from -1 to 1 over the square.
fn coordinates(index: usize, stride: usize, middle: f64) -> Vector3<f64> {
    Vector3::new(
        1.0,
        ((index % stride) as f64 - middle) / middle,
        ((index / stride) as f64 - middle) / middle,
    )
}

/// Returns the Laplacian of a zero-padded tile, one pixel wider on each side.
fn laplacian(tile: &[f64], side: usize) -> Vec<f64> {
    let wide = side + 2;
    let mut out = vec![0.0; wide * wide];
    for (k, value) in tile.iter().enumerate() {
        let at = (k / side + 1) * wide + k % side + 1;
        out[at] += 4.0 * value;
        for next in [at - 1, at + 1, at - wide, at + wide] {
            out[next] -= value;
        }
    }
    out
}

/// Applies the transpose of [`laplacian`].
fn laplacian_back(wide_tile: &[f64], side: usize) -> Vec<f64> {
    let wide = side + 2;
    (0..side * side)
        .map(|k| {
            let at = (k / side + 1) * wide + k % side + 1;
            let about: f64 = [at - 1, at + 1, at - wide, at + wide]
                .iter()
                .map(|&next| wide_tile[next])
                .sum();
            4.0 * wide_tile[at] - about
        })
        .collect()
}

/// The least-squares problem of one patch.
struct Problem<'a> {
    plans: &'a Plans,
    patch: &'a Patch,
    sharp: Vec<Complex<f64>>,
    /// Power spectrum of the weighted sharp picture at the resolution of a tile.
    power: Vec<f64>,
    /// Sum of squared weights over the sum of weights.
    taper: f64,
}

impl<'a> Problem<'a> {
    fn new(plans: &'a Plans, patch: &'a Patch) -> Self {
        let helix = &plans.window;
        let squares: f64 = patch.weight.iter().map(|w| w * w).sum();
        Self {
            plans,
            patch,
            sharp: helix.spectrum(helix.laid_out(&patch.sharp, helix.stride)),
            power: power(plans, patch),
            taper: squares / patch.pixels(),
        }
    }

    /// Convolves the sharp picture with `tile`.
    fn blurred(&self, tile: &[f64]) -> Vec<f64> {
        let helix = &self.plans.window;
        let mut spectrum = helix.spectrum(helix.laid_out(tile, self.plans.side));
        for (s, i) in spectrum.iter_mut().zip(&self.sharp) {
            *s *= i;
        }
        helix.values(spectrum)
    }

    /// Applies the transpose of [`Problem::blurred`] to the weighted `values`.
    fn correlate_weighted(&self, values: &[f64]) -> Vec<f64> {
        let helix = &self.plans.window;
        let mut weighed: Vec<f64> = self
            .patch
            .weight
            .iter()
            .zip(values)
            .map(|(w, v)| w * v)
            .collect();
        weighed.resize(helix.length, 0.0);
        let mut spectrum = helix.spectrum(weighed);
        for (s, i) in spectrum.iter_mut().zip(&self.sharp) {
            *s *= i.conj();
        }
        helix.cut_out(&helix.values(spectrum), self.plans.side)
    }

    /// Multiplies `tile` by the normal matrix.
    fn normal(&self, tile: &[f64], lambda: f64) -> Vec<f64> {
        let mut out = self.correlate_weighted(&self.blurred(tile));
        let smooth = laplacian_back(&laplacian(tile, self.plans.side), self.plans.side);
        for (o, s) in out.iter_mut().zip(&smooth) {
            *o += lambda * s;
        }
        out
    }

    /// Preconditioner: inverse of the circulant approximation of the normal matrix.
    fn nearly_solved(&self, values: &[f64], filter: &[f64]) -> Vec<f64> {
        let (helix, side) = (&self.plans.tile, self.plans.side);
        let mut spectrum = helix.spectrum(helix.laid_out(values, side));
        for (s, f) in spectrum.iter_mut().zip(filter) {
            *s *= f;
        }
        helix.cut_out(&helix.values(spectrum), side)
    }

    /// Solves the normal equations by preconditioned conjugate gradients from `tile`.
    fn solve(&self, tile: &mut [f64], target: &[f64], lambda: f64) {
        let floor = 1e-12 * self.power.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let filter: Vec<f64> = self
            .power
            .iter()
            .zip(&self.plans.rough)
            .map(|(p, r)| 1.0 / (p + lambda * r + floor))
            .collect();
        let start = self.normal(tile, lambda);
        let mut residual: Vec<f64> = target.iter().zip(&start).map(|(t, s)| t - s).collect();
        let mut solved = self.nearly_solved(&residual, &filter);
        let goal = TOLERANCE * TOLERANCE * dot(target, &self.nearly_solved(target, &filter));
        let mut direction = solved.clone();
        let mut size = dot(&residual, &solved);
        for _ in 0..STEPS {
            if size <= goal {
                break;
            }
            let turned = self.normal(&direction, lambda);
            let step = size / dot(&direction, &turned).max(f64::MIN_POSITIVE);
            for k in 0..tile.len() {
                tile[k] += step * direction[k];
                residual[k] -= step * turned[k];
            }
            solved = self.nearly_solved(&residual, &filter);
            let next = dot(&residual, &solved);
            for (d, s) in direction.iter_mut().zip(&solved) {
                *d = s + next / size * *d;
            }
            size = next;
        }
    }

    /// Returns the weighted squared residual of `tile`.
    fn misfit(&self, difference: &[f64], tile: &[f64]) -> f64 {
        let blurred = self.blurred(tile);
        self.patch
            .weighted(|k| (difference[k] - blurred[k]).powi(2))
    }

    /// Returns the transfer function of the estimator.
    fn transfer(&self, lambda: f64) -> Vec<f64> {
        let terms = self.power.iter().zip(&self.plans.rough);
        terms
            .map(|(p, r)| p / (p + lambda * r).max(f64::MIN_POSITIVE))
            .collect()
    }

    /// Returns the noise variance over the mean square Laplacian of a tile whose Laplacian has the squared norm `rough`,
    /// counted over the samples that the data determine.
    fn lambda(&self, noise: f64, rough: f64) -> f64 {
        let unknowns = (self.plans.side * self.plans.side) as f64;
        let mut lambda = noise * unknowns / rough;
        for _ in 0..4 {
            let known = unknowns * self.mean(&self.transfer(lambda));
            lambda = noise * known.max(1.0) / rough;
        }
        lambda
    }

    /// Returns the expected weighted squared residual of noise of unit variance.
    fn residual_freedom(&self, lambda: f64) -> f64 {
        let transfer = self.transfer(lambda);
        let used: Vec<f64> = transfer.iter().map(|t| 2.0 * t - t * t).collect();
        let unknowns = (self.plans.side * self.plans.side) as f64;
        self.patch.pixels() - self.taper * unknowns * self.mean(&used)
    }

    /// Returns the power spectrum of a tile's noise for noise of unit variance in the plate.
    fn noise_spectrum(&self, lambda: f64) -> Vec<f64> {
        let terms = self.power.iter().zip(&self.plans.rough);
        terms
            .map(|(p, r)| self.taper * p / (p + lambda * r).powi(2).max(f64::MIN_POSITIVE))
            .collect()
    }

    /// Returns the energy of a tile estimated from white noise of unit variance.
    fn simulated_energy(&self, lambda: f64, seed: u64) -> f64 {
        let mut random = SplitMix64::new(seed);
        let noise: Vec<f64> = (0..self.patch.weight.len())
            .map(|_| {
                // Four uniform numbers have a variance of a third.
                let sum: f64 = (0..4).map(|_| random.unit() - 0.5).sum();
                sum * 3.0_f64.sqrt()
            })
            .collect();
        let mut tile = vec![0.0; self.plans.side * self.plans.side];
        self.solve(&mut tile, &self.correlate_weighted(&noise), lambda);
        tile.iter().map(|v| v * v).sum()
    }

    /// Returns the mean of `spectrum` over all frequencies.
    fn mean(&self, spectrum: &[f64]) -> f64 {
        let helix = &self.plans.tile;
        let terms = spectrum.iter().enumerate();
        let sum: f64 = terms.map(|(k, v)| helix.multiplicity(k) * v).sum();
        sum / helix.length as f64
    }
}

/// Returns the power spectrum of the weighted sharp picture, smoothed by a triangular lag window as wide as the tile
/// (Bartlett): the non-negative spectrum of the normal matrix.
fn power(plans: &Plans, patch: &Patch) -> Vec<f64> {
    let (window, tile) = (&plans.window, &plans.tile);
    // Weights are stored half a tile below and right of the sharp pixel at their centre.
    let half = window.lag(plans.side as isize / 2, plans.side as isize / 2);
    let mut seen = vec![0.0; window.length];
    for (k, weight) in patch.weight.iter().enumerate().filter(|(_, w)| **w > 0.0) {
        seen[k] = weight.sqrt() * patch.sharp[k - half];
    }
    let spectrum = window.spectrum(seen);
    let power = spectrum.iter().map(|s| Complex::new(s.norm_sqr(), 0.0));
    let correlation = window.values(power.collect());
    let mut kept = vec![0.0; tile.length];
    let reach = plans.side as isize;
    for y in 1 - reach..reach {
        for x in 1 - reach..reach {
            let fall = |v: isize| 1.0 - v.abs() as f64 / reach as f64;
            // Lags beyond the period wrap: the spectrum is sampled at fewer frequencies.
            kept[tile.lag(y, x)] += fall(x) * fall(y) * correlation[window.lag(y, x)];
        }
    }
    let spectrum = tile.spectrum(kept);
    spectrum.iter().map(|s| s.re.max(0.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_laplacian_and_its_transpose_agree() {
        let (side, wide) = (5, 7);
        let a: Vec<f64> = (0..side * side).map(|k| (k as f64 * 0.7).sin()).collect();
        let b: Vec<f64> = (0..wide * wide).map(|k| (k as f64 * 1.1).cos()).collect();
        let left: f64 = laplacian(&a, side).iter().zip(&b).map(|(x, y)| x * y).sum();
        let right: f64 = laplacian_back(&b, side)
            .iter()
            .zip(&a)
            .map(|(x, y)| x * y)
            .sum();
        assert!((left - right).abs() < 1e-12);
    }
}
