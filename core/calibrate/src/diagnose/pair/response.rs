//! Response of the estimator: the PSF that it would return for a given one.

use std::sync::Arc;

use crate::helix::Helix;
use seidel_fourier::Complex;

/// The response of the estimator of one tile.
///
/// The estimator adds to the PSF expected of the lens a regularised estimate of the difference from it. It is linear in
/// that difference, so a PSF `p` would be estimated as `expected` + T (p - `expected`), without noise. T is the transfer
/// function of the estimator in the circulant approximation, between 0 and 1. A prediction goes through the same response
/// before it is compared with the estimate, so that regularisation is never taken for blur.
#[derive(Debug, Clone)]
pub struct TileResponse {
    pub(super) helix: Arc<Helix>,
    pub(super) side: usize,
    /// Samples of the expected PSF, of unit sum.
    pub(super) expected: Vec<f64>,
    /// Transfer function at the frequencies of `helix`.
    pub(super) transfer: Vec<f64>,
    /// Effective number of independent samples in the noise of the tile.
    pub(super) noise_freedom: f64,
}

impl TileResponse {
    /// Effective number of independent samples in the noise of the tile.
    pub fn noise_freedom(&self) -> f64 {
        self.noise_freedom
    }

    /// Replaces the samples of `tile`, of unit sum, by those that the estimator would return for it.
    ///
    /// # Panics
    /// If `tile` is not as large as the estimated one.
    pub fn apply(&self, tile: &mut [f64]) {
        assert_eq!(tile.len(), self.expected.len(), "one size");
        for (value, expected) in tile.iter_mut().zip(&self.expected) {
            *value -= expected;
        }
        self.apply_to_change(tile);
        for (value, expected) in tile.iter_mut().zip(&self.expected) {
            *value += expected;
        }
    }

    /// Replaces `change`, a difference of two tiles, by that of their estimates.
    pub(crate) fn apply_to_change(&self, change: &mut [f64]) {
        let mut spectrum = self.helix.spectrum(self.helix.laid_out(change, self.side));
        for (value, transfer) in spectrum.iter_mut().zip(&self.transfer) {
            *value *= Complex::new(*transfer, 0.0);
        }
        let passed = self.helix.cut_out(&self.helix.values(spectrum), self.side);
        change.copy_from_slice(&passed);
    }
}

/// Returns the transforms for tiles of side `side`. The period exceeds the tile by half of it, farther than responses reach.
pub(super) fn response_helix(side: usize) -> Helix {
    let period = side + side / 2;
    Helix::new(period, period)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_expected_psf_is_returned_unchanged_and_differences_are_filtered() {
        let side = 9;
        let helix = Arc::new(response_helix(side));
        let expected: Vec<f64> = (0..side * side).map(|k| (k as f64 * 0.3).sin()).collect();
        let response = TileResponse {
            side,
            transfer: vec![0.25; helix.length / 2 + 1],
            expected: expected.clone(),
            noise_freedom: 1.0,
            helix,
        };
        let mut tile = expected.clone();
        response.apply(&mut tile);
        let error = |a: &[f64], b: &[f64]| {
            let pairs = a.iter().zip(b);
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!(error(&tile, &expected) < 1e-12);
        tile[40] += 1.0;
        response.apply(&mut tile);
        let mut want = expected;
        want[40] += 0.25;
        assert!(error(&tile, &want) < 1e-12);
    }
}
