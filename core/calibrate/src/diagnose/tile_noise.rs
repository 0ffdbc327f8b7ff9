//! The contribution of pixel noise to the gap of a tile, and to its sum.

/// Relative standard error of the sum of a tile at which half of its variance is removed from residuals.
const FLUX_TOLERANCE: f64 = 0.1;
/// Least share of the squared norm of the samples that is taken for light, in very noisy tiles.
const MIN_LIGHT_SHARE: f64 = 0.05;

/// The contribution of noise to the gap of a tile.
pub(super) struct TileNoise {
    /// Squared norm of the samples without noise.
    pub(super) norm: f64,
    /// Expected contribution to the gap.
    pub(super) noise: f64,
    /// Share of the flux error to remove from residuals, 0 to 1.
    pub(super) free_flux: f64,
    /// Part of `noise` that is the error of the sum.
    pub(super) of_sum: f64,
}

impl TileNoise {
    /// Returns the contributions of pixel noise of standard deviation `sigma` to `pixels` samples of unit sum, whose squared
    /// norm is `norm`.
    ///
    /// A residual is n_i - p_i sum(n) with n the noise and p the PSF: the sum of the tile is noisy too. Along p its variance is
    /// sigma² (1 / |p|² - 2 + K) |p|² for K pixels, of which the free flux leaves the share (1 - t)²; elsewhere it is
    /// (K - 1) sigma².
    pub(super) fn new(norm: f64, pixels: f64, sigma: f64) -> Self {
        let of_sum = pixels * sigma * sigma;
        let free_flux = of_sum / (of_sum + FLUX_TOLERANCE * FLUX_TOLERANCE);
        Self::with_free_flux(norm, pixels, sigma, free_flux)
    }

    /// As [`TileNoise::new`], with the share of the flux error that residuals do not hold.
    pub(super) fn with_free_flux(norm: f64, pixels: f64, sigma: f64, free_flux: f64) -> Self {
        let variance = sigma * sigma;
        let light = (norm - pixels * variance).max(MIN_LIGHT_SHARE * norm);
        let along = (1.0 - free_flux).powi(2) * (1.0 + (pixels - 2.0) * light);
        Self {
            norm: light,
            noise: variance * (pixels - 1.0 + along) / light,
            free_flux,
            of_sum: variance * along / light,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::numeric::SplitMix64;

    /// Returns a standard normal number by the Box-Muller transform.
    fn normal(random: &mut SplitMix64) -> f64 {
        let radius = (-2.0 * random.unit().max(1e-300).ln()).sqrt();
        radius * (std::f64::consts::TAU * random.unit()).cos()
    }

    #[test]
    fn the_floor_is_the_mean_gap_of_a_right_prediction() {
        const SIDE: usize = 65;
        for (width, sigma) in [(2.0, 2e-4), (2.0, 2e-3), (5.0, 3e-4), (1.0, 6e-3)] {
            let psf: Vec<f64> = (0..SIDE * SIDE)
                .map(|k| {
                    let (x, y) = ((k % SIDE) as f64 - 32.0, (k / SIDE) as f64 - 32.0);
                    (-(x * x + y * y) / (2.0 * width * width)).exp()
                })
                .collect();
            let sum: f64 = psf.iter().sum();
            let psf: Vec<f64> = psf.iter().map(|p| p / sum).collect();
            let (mut gaps, mut floors) = (0.0, 0.0);
            let mut random = SplitMix64::new(7);
            const DRAWS: usize = 200;
            for _ in 0..DRAWS {
                let noisy: Vec<f64> = psf
                    .iter()
                    .map(|p| p + sigma * normal(&mut random))
                    .collect();
                let sum: f64 = noisy.iter().sum();
                if sum < 0.3 {
                    continue;
                }
                let light: Vec<f64> = noisy.iter().map(|v| v / sum).collect();
                let norm: f64 = light.iter().map(|v| v * v).sum();
                let known = TileNoise::new(norm, light.len() as f64, sigma / sum);
                let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                let apart: Vec<f64> = light.iter().zip(&psf).map(|(o, p)| o - p).collect();
                let share = known.free_flux * dot(&apart, &psf) / dot(&psf, &psf);
                let left: Vec<f64> = apart.iter().zip(&psf).map(|(r, p)| r - share * p).collect();
                gaps += dot(&left, &left) / known.norm;
                floors += known.noise;
            }
            assert!(
                (gaps / floors - 1.0).abs() < 0.05,
                "{width} {sigma}: {gaps} {floors}"
            );
        }
    }
}
