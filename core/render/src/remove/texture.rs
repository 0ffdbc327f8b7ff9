//! Correction of texture by Wiener filters on small tiles, with the power spectrum of the estimate as the prior.
//!
//! Total variation flattens weak texture, and draws edges where the plate is smooth because its camera was. At each
//! frequency of a tile let X be the estimate, R the residual b - A x, h the transfer function, N the power of the noise
//! and P = 1.5 |X|². The correction is
//!
//! ```text
//! s (h* P R - g N X) / (|h|² P + N)
//! ```
//!
//! With s = g = 1 it turns X into the Wiener estimate h* P (h X + R) / (|h|² P + N). The shrinkage g is the share of this
//! filter's attenuation that is applied. The strength s is below one in tiles where the spectrum is a poor prior: where
//! there are only a few edges, hardly more than noise, or a residual that the noise does not explain.

use super::overlapping_tiles::OverlappingTiles;
use super::ramp;
use super::tile_fft::{FftBuffers, TileFft};
use super::transfer_functions::TransferFunctions;
use rayon::prelude::*;
use seidel_fourier::Complex;

/// Side of a tile, px, where the sides of the lens's tiles allow it.
const SIDE: usize = 32;
/// Ratio of those sides otherwise.
const FALLBACK_DIVISOR: usize = 3;
/// P / |X|²: the estimate has less power than the true image.
const POWER_RATIO: f32 = 1.5;
/// The least shrinkage g. Frequencies that total variation alone determines are right in drawn images and wrong in
/// photographs of soft subjects; 0.65 keeps most of the gain in both (docs/background/figures.md).
const MIN_SHRINKAGE: f32 = 0.65;
/// Evenness of gradients between which g rises from its least value to 1: such gradients are distributed like those of
/// noise, from which total variation infers nothing.
const NOISE_EVENNESS: [f32; 2] = [0.65, 0.75];
/// Evenness of gradients, mean² / mean square, between which s rises from 0 to 1: less even ones are a few edges.
const TEXTURE_EVENNESS: [f32; 2] = [0.25, 0.35];
/// Root mean square gradients between which s rises from 0 to 1, in standard deviations of the noise: smaller ones show no
/// detail.
const TEXTURE_GRADIENT: [f32; 2] = [0.3, 1.2];
/// Root mean square residuals between which s rises from 0 to 1, in standard deviations of the noise: larger ones are
/// errors of the model, and fitting them makes the image ring.
pub(super) const EXPLAINED_RESIDUAL: [f32; 2] = [2.0, 1.2];

/// An estimate of a plane's sharp image.
pub(super) struct Estimate<'a> {
    /// x.
    pub(super) image: &'a [f32],
    /// W (b - A x).
    pub(super) residual: &'a [f32],
    /// |D x| of each pixel.
    pub(super) gradient_norms: &'a [f32],
    /// Standard deviation of the plate's noise and model error.
    pub(super) deviation: f32,
}

/// Returns the correction of `estimate`, planes of `size`.
///
/// Tiles that `coverage` does not cover wholly are not corrected: the light of another layer is in their spectrum.
pub(super) fn texture_correction(
    transfer: &TransferFunctions,
    size: (usize, usize),
    estimate: &Estimate,
    coverage: Option<&[f32]>,
) -> Vec<f32> {
    let lens_side = transfer.tiles.side;
    let divisor = if lens_side.is_multiple_of(3 * SIDE) {
        lens_side / SIDE
    } else {
        FALLBACK_DIVISOR
    };
    let tiles = OverlappingTiles::new(size, lens_side / divisor);
    let fft = TileFft::new(tiles.side);
    let noise_power = estimate.deviation.powi(2) * tiles.window_energy();
    let corrections: Vec<_> = (tiles.tiles)
        .par_iter()
        .map_init(FftBuffers::default, |buffers, tile| {
            if coverage.is_some_and(|coverage| !tiles.is_covered(coverage, *tile)) {
                return None;
            }
            let mut residual = tiles.cut(estimate.residual, *tile);
            let gradient_norms = tiles.cut(estimate.gradient_norms, *tile);
            let filter = TileFilter::new(&gradient_norms, &residual, &tiles, estimate.deviation)?;
            let mut samples = tiles.cut(estimate.image, *tile);
            fft.forward(&mut samples, buffers);
            let image = buffers.spectrum.clone();
            fft.forward(&mut residual, buffers);
            let (x, y) = tiles.centre(*tile);
            let transfer = transfer.at(x, y, divisor);
            for ((value, image), h) in buffers.spectrum.iter_mut().zip(&image).zip(transfer) {
                *value = filter.correction(*image, *value, h, noise_power);
            }
            fft.inverse(buffers, &mut samples);
            Some(samples)
        })
        .collect();
    tiles.overlap_add(&corrections)
}

/// The parameters of a tile's filter.
struct TileFilter {
    /// s, above 0 and up to 1.
    strength: f32,
    /// g.
    shrinkage: f32,
}

impl TileFilter {
    /// Chooses the parameters for a tile from its windowed gradient norms and its windowed residual. Returns `None` if the
    /// tile needs no correction.
    fn new(
        gradient_norms: &[f32],
        residual: &[f32],
        tiles: &OverlappingTiles,
        deviation: f32,
    ) -> Option<Self> {
        let (mut gradient_sum, mut gradient_squares, mut residual_squares) = (0.0, 0.0, 0.0);
        for (norm, residual) in gradient_norms.iter().zip(residual) {
            gradient_sum += norm;
            gradient_squares += norm * norm;
            residual_squares += residual * residual;
        }
        if gradient_squares == 0.0 || deviation == 0.0 {
            return None;
        }
        let energy = tiles.window_energy();
        let mean_gradient = gradient_sum / tiles.window_sum();
        let (mean_square, residual_variance) =
            (gradient_squares / energy, residual_squares / energy);
        let evenness = mean_gradient * mean_gradient / mean_square;
        let strength = ramp(evenness, TEXTURE_EVENNESS)
            * ramp(mean_square.sqrt() / deviation, TEXTURE_GRADIENT)
            * ramp(residual_variance.sqrt() / deviation, EXPLAINED_RESIDUAL);
        (strength > 0.0).then(|| Self {
            strength,
            shrinkage: MIN_SHRINKAGE + (1.0 - MIN_SHRINKAGE) * ramp(evenness, NOISE_EVENNESS),
        })
    }

    /// Returns the correction of one frequency of the `image`, given the residual there.
    fn correction(
        &self,
        image: Complex<f32>,
        residual: Complex<f32>,
        h: Complex<f32>,
        noise_power: f32,
    ) -> Complex<f32> {
        let power = POWER_RATIO * image.norm_sqr();
        let total = h.norm_sqr() * power + noise_power;
        let wiener = (h.conj() * residual * power - image * (self.shrinkage * noise_power)) / total;
        wiener * self.strength
    }
}
