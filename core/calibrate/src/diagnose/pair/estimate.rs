//! PSF of one patch by regularised least squares with evidence maximisation.

use seidel_fourier::Complex;

use super::helix::Helix;

/// Iterations of estimating noise variance and roughness from the patch.
const ROUNDS: usize = 4;
/// Conjugate-gradient steps per iteration, and the relative residual at which they stop.
const STEPS: usize = 80;
const TOLERANCE: f64 = 1e-5;
/// Lower bound of the noise relative to the light: plates are quantised.
const LEAST_NOISE: f64 = 1e-6;
/// Share of noise energy in the tile's energy above which the patch is rejected.
const MOST_NOISE: f64 = 0.25;
/// Minimum number of valid pixels per pixel of the tile.
const LEAST_PIXELS: f64 = 2.0;
/// Minimum contrast of a patch.
const LEAST_CONTRAST: f64 = 1e-3;

/// Data of one patch in one channel.
pub(super) struct Patch {
    /// The sharp image on the square of the helix's stride.
    pub(super) sharp: Vec<f64>,
    /// The plate in the same layout; only pixels with weight are read.
    pub(super) plate: Vec<f64>,
    /// Weights of the plate's pixels; zero in the first rows and columns, whose light comes from outside the
    /// square.
    pub(super) weight: Vec<f64>,
}

/// An estimated PSF.
pub(super) struct Estimate {
    /// Samples, row-major.
    pub(super) tile: Vec<f64>,
    /// Posterior standard deviation of a sample.
    pub(super) sigma: f64,
}

/// Estimates the PSF of side `side` that maps the sharp image to the plate; `None` where the patch does not
/// determine it.
///
/// Minimises the weighted squared residual plus lambda times the squared Laplacian. This regularisation acts
/// on the fourth power of frequency, so it leaves second moments unbiased. Noise variance and lambda maximise
/// the evidence (MacKay 1992). The returned noise is that of the posterior, and includes frequencies that the
/// sharp image lacks.
pub(super) fn estimate(helix: &Helix, patch: &Patch, side: usize) -> Option<Estimate> {
    let pixels: f64 = patch.weight.iter().sum();
    let unknowns = (side * side) as f64;
    if pixels < LEAST_PIXELS * unknowns || contrast(patch) < LEAST_CONTRAST {
        return None;
    }
    let mean_square = weighed(patch, |k| patch.plate[k].powi(2)) / pixels;
    let least = (LEAST_NOISE * LEAST_NOISE * mean_square).max(f64::MIN_POSITIVE);
    let problem = Problem::new(helix, patch, side);
    let mut tile = vec![0.0; side * side];
    let mut noise = (1e-4 * mean_square).max(least);
    let mut roughness = first_roughness(side);
    for round in 0..=ROUNDS {
        let lambda = noise / roughness;
        problem.solve(&mut tile, lambda);
        let known = unknowns * problem.known_share(lambda);
        if round == ROUNDS {
            let variance = problem.posterior_variance(noise, lambda);
            let energy: f64 = tile.iter().map(|v| v * v).sum();
            let is_determined =
                unknowns * variance < MOST_NOISE * energy && tile.iter().sum::<f64>() > 0.0;
            return (is_determined && variance.is_finite()).then(|| Estimate {
                sigma: variance.sqrt(),
                tile,
            });
        }
        let misfit = problem.misfit(&tile);
        noise = (misfit / (pixels - known).max(0.1 * pixels)).max(least);
        let rough: f64 = laplacian(&tile, side).iter().map(|v| v * v).sum();
        roughness = (rough / known.max(1.0)).max(f64::MIN_POSITIVE);
    }
    None
}

fn weighed(patch: &Patch, f: impl Fn(usize) -> f64) -> f64 {
    let weights = patch.weight.iter().enumerate();
    weights
        .filter(|(_, w)| **w > 0.0)
        .map(|(k, w)| w * f(k))
        .sum()
}

/// Returns the standard deviation of the sharp image relative to its mean light.
fn contrast(patch: &Patch) -> f64 {
    let count = patch.sharp.len() as f64;
    let mean = patch.sharp.iter().sum::<f64>() / count;
    let square = patch.sharp.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
    let light = patch.sharp.iter().map(|v| v.abs()).sum::<f64>() / count;
    square.sqrt() / light.max(f64::MIN_POSITIVE)
}

/// Returns the mean square Laplacian of a unit-sum Gaussian a tenth of the tile wide, as an initial value.
fn first_roughness(side: usize) -> f64 {
    let (sigma, middle) = (side as f64 / 10.0, (side as f64 - 1.0) / 2.0);
    let bell: Vec<f64> = (0..side * side)
        .map(|k| {
            let (x, y) = ((k % side) as f64 - middle, (k / side) as f64 - middle);
            (-(x * x + y * y) / (2.0 * sigma * sigma)).exp()
        })
        .collect();
    let sum: f64 = bell.iter().sum();
    let rough: f64 = laplacian(&bell, side).iter().map(|v| v * v).sum();
    rough / (sum * sum * bell.len() as f64)
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
    helix: &'a Helix,
    patch: &'a Patch,
    side: usize,
    sharp: Vec<Complex<f64>>,
    /// Correlation of the weighted plate with the sharp image.
    target: Vec<f64>,
    /// Power spectrum of the sharp image at the resolution of a tile.
    power: Vec<f64>,
    rough: Vec<f64>,
}

impl<'a> Problem<'a> {
    fn new(helix: &'a Helix, patch: &'a Patch, side: usize) -> Self {
        let sharp = helix.spectrum(helix.laid_out(&patch.sharp, helix.stride));
        let mut problem = Self {
            helix,
            patch,
            side,
            power: power(helix, patch, side),
            rough: helix.laplacian_power(),
            target: Vec::new(),
            sharp,
        };
        let light = patch.weight.iter().zip(&patch.plate);
        let mut weighed: Vec<f64> = light
            .map(|(w, v)| if *w > 0.0 { w * v } else { 0.0 })
            .collect();
        weighed.resize(helix.length, 0.0);
        problem.target = problem.correlate(weighed);
        problem
    }

    /// Convolves the sharp image with `tile`.
    fn blurred(&self, tile: &[f64]) -> Vec<f64> {
        let laid = self.helix.laid_out(tile, self.side);
        let mut spectrum = self.helix.spectrum(laid);
        for (s, i) in spectrum.iter_mut().zip(&self.sharp) {
            *s *= i;
        }
        self.helix.values(spectrum)
    }

    /// Applies the transpose of [`Problem::blurred`].
    fn correlate(&self, values: Vec<f64>) -> Vec<f64> {
        let mut spectrum = self.helix.spectrum(values);
        for (s, i) in spectrum.iter_mut().zip(&self.sharp) {
            *s *= i.conj();
        }
        let values = self.helix.values(spectrum);
        self.helix.cut_out(&values, self.side)
    }

    /// Multiplies `tile` by the normal matrix.
    fn normal(&self, tile: &[f64], lambda: f64) -> Vec<f64> {
        let mut blurred = self.blurred(tile);
        for (k, value) in blurred.iter_mut().enumerate() {
            *value *= self.patch.weight.get(k).copied().unwrap_or(0.0);
        }
        let mut out = self.correlate(blurred);
        let smooth = laplacian_back(&laplacian(tile, self.side), self.side);
        for (o, s) in out.iter_mut().zip(&smooth) {
            *o += lambda * s;
        }
        out
    }

    /// Preconditioner: inverse of the circulant approximation of the normal matrix.
    fn nearly_solved(&self, values: &[f64], filter: &[f64]) -> Vec<f64> {
        let mut spectrum = self.helix.spectrum(self.helix.laid_out(values, self.side));
        for (s, f) in spectrum.iter_mut().zip(filter) {
            *s *= f;
        }
        let values = self.helix.values(spectrum);
        self.helix.cut_out(&values, self.side)
    }

    /// Solves the normal equations by preconditioned conjugate gradients from `tile`.
    fn solve(&self, tile: &mut [f64], lambda: f64) {
        let floor = 1e-12 * self.power.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let filter: Vec<f64> = self
            .power
            .iter()
            .zip(&self.rough)
            .map(|(p, r)| 1.0 / (p + lambda * r + floor))
            .collect();
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let start = self.normal(tile, lambda);
        let mut residual: Vec<f64> = self.target.iter().zip(&start).map(|(t, s)| t - s).collect();
        let mut solved = self.nearly_solved(&residual, &filter);
        let goal =
            TOLERANCE * TOLERANCE * dot(&self.target, &self.nearly_solved(&self.target, &filter));
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
    fn misfit(&self, tile: &[f64]) -> f64 {
        let blurred = self.blurred(tile);
        weighed(self.patch, |k| (self.patch.plate[k] - blurred[k]).powi(2))
    }

    /// Returns the effective share of parameters determined by the data rather than by the prior.
    fn known_share(&self, lambda: f64) -> f64 {
        self.mean(|power, rough| power / (power + lambda * rough).max(f64::MIN_POSITIVE))
    }

    /// Returns the mean posterior variance of the samples.
    fn posterior_variance(&self, noise: f64, lambda: f64) -> f64 {
        self.mean(|power, rough| noise / (power + lambda * rough).max(f64::MIN_POSITIVE))
    }

    fn mean(&self, f: impl Fn(f64, f64) -> f64) -> f64 {
        let terms = self.power.iter().zip(&self.rough).enumerate();
        let sum: f64 = terms
            .map(|(k, (&p, &r))| self.helix.multiplicity(k) * f(p, r))
            .sum();
        sum / self.helix.length as f64
    }
}

/// Returns the power spectrum of the weighted sharp image, smoothed by a triangular lag window as wide as the
/// tile (Bartlett): the non-negative spectrum of the normal matrix.
fn power(helix: &Helix, patch: &Patch, side: usize) -> Vec<f64> {
    // Weights are stored half a tile below and right of the sharp pixel at their centre.
    let half = helix.lag(side as isize / 2, side as isize / 2);
    let mut seen = vec![0.0; helix.length];
    for (k, weight) in patch.weight.iter().enumerate().filter(|(_, w)| **w > 0.0) {
        seen[k] = weight.sqrt() * patch.sharp[k - half];
    }
    let spectrum = helix.spectrum(seen);
    let power = spectrum.iter().map(|s| Complex::new(s.norm_sqr(), 0.0));
    let correlation = helix.values(power.collect());
    let mut kept = vec![0.0; helix.length];
    let reach = side as isize;
    for y in 1 - reach..reach {
        for x in 1 - reach..reach {
            let fall = |v: isize| 1.0 - v.abs() as f64 / reach as f64;
            let at = helix.lag(y, x);
            kept[at] = fall(x) * fall(y) * correlation[at];
        }
    }
    let spectrum = helix.spectrum(kept);
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
