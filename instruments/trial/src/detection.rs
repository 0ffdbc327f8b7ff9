//! The smallest gap that noise and an ordinary fit allow a diagnosis to see.

use super::expose::{Spot, noise_sigma};
use super::lens::CHANNELS;
use super::simulated::SimulatedLens;

/// Own gap of an adequately fitted lens, and the gap that discretisation allows.
const OWN_GAP: f64 = 5e-4;
const DISCRETISATION: f64 = 2e-4;
/// Ratio of a visible gap to those two.
const VISIBLE_RATIO: f64 = 2.5;
/// Standard errors of the mean gap that a visible gap exceeds.
const SIGMAS: f64 = 5.0;

/// The noise of a real set.
#[derive(Debug, Clone, Copy)]
pub(super) struct SetNoise {
    /// Peak over the standard deviation of the noise.
    pub(super) snr: f64,
    /// Number of spots of the set.
    pub(super) spots: usize,
    /// Width and height of tiles, pixels.
    pub(super) tile: usize,
}

/// Returns the approximate detection limit: 2.5 (0.0005 + 0.0002) + 5 s.
///
/// s is the standard error of the mean gap from noise. With P pixels of standard deviation σ, noise adds n = P σ² / |o|² to
/// the gap |o - p|² / |o|² of a tile. Its variance is (2 n² + 4 g n) / P, where g is the gap itself, here the first part
/// of the limit. The mean over T tiles has a T-th of that. n is a mean over `probes`, tiles of the bare lens.
pub(super) fn detection_limit<L: SimulatedLens>(lens: &L, probes: &[Spot], noise: SetNoise) -> f64 {
    let pixels = (noise.tile * noise.tile) as f64;
    let (mut sum, mut count) = (0.0, 0.0);
    for spot in probes {
        for tile in lens.bare_tiles(spot, noise.tile) {
            let peak = tile.iter().copied().fold(0.0, f64::max);
            let energy: f64 = tile.iter().map(|v| v * v).sum();
            sum += pixels * noise_sigma(&tile, peak, noise.snr).powi(2) / energy;
            count += 1.0;
        }
    }
    let added = sum / count;
    let own = VISIBLE_RATIO * (OWN_GAP + DISCRETISATION);
    let variance = (2.0 * added * added + 4.0 * own * added) / pixels;
    let tiles = (noise.spots * CHANNELS.len()) as f64;
    own + SIGMAS * (variance / tiles).sqrt()
}
