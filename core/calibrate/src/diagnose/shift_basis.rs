//! Image changes that a shift of a tile causes.

use super::prediction::central_difference;
use super::tiles::TileData;

/// Orthonormal basis of the image changes caused by a shift. It is projected out of residuals of tiles
/// without an ideal position.
pub(super) struct ShiftBasis([Vec<f64>; 2]);

impl ShiftBasis {
    /// Creates the basis for a `prediction` of `tile`.
    pub(super) fn new(tile: &TileData, prediction: &[f64]) -> Self {
        let mut pair = [(1, 0), (0, 1)].map(|step| central_difference(prediction, tile.size, step));
        for (index, counts) in tile.counts.iter().enumerate() {
            if !counts {
                pair[0][index] = 0.0;
                pair[1][index] = 0.0;
            }
        }
        let [first, second] = &mut pair;
        normalise(first);
        subtract_projection(second, first);
        normalise(second);
        Self(pair)
    }

    /// Subtracts from `values` their projection onto the basis.
    pub(super) fn remove_from(&self, values: &mut [f64]) {
        for shift in &self.0 {
            subtract_projection(values, shift);
        }
    }
}

/// Subtracts from `values` their projection onto the unit vector `direction`.
fn subtract_projection(values: &mut [f64], direction: &[f64]) {
    let along = direction
        .iter()
        .zip(&*values)
        .map(|(a, b)| a * b)
        .sum::<f64>();
    for (value, d) in values.iter_mut().zip(direction) {
        *value -= along * d;
    }
}

fn normalise(values: &mut [f64]) {
    let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    if norm > 0.0 {
        values.iter_mut().for_each(|v| *v /= norm);
    }
}
