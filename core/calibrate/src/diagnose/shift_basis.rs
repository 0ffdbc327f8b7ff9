//! Image changes that shifts of unknown size cause: they are projected out of residuals.

use super::prediction::central_difference;
use super::registration::Registration;
use super::tiles::TileData;

/// Orthonormal basis of the image changes by the unknown shifts of an observation. Vectors run over the pixels of all of its
/// tiles, one tile after the other, each times its scale.
pub(super) struct ShiftBasis(Vec<Vec<f64>>);

/// A tile with its prediction.
pub(super) struct PredictedTile<'a> {
    pub(super) tile: &'a TileData,
    pub(super) prediction: &'a [f64],
    /// Factor of its pixels in the cost: the root of weight over squared norm.
    pub(super) scale: f64,
}

impl ShiftBasis {
    /// Creates the basis for the `tiles` of one observation: no shift if its position is stated, one shift if it is placed by
    /// its reference channel, and one for each tile that is placed by its own centroid.
    pub(super) fn new(tiles: &[PredictedTile]) -> Self {
        let Some(first) = tiles.first() else {
            return Self(Vec::new());
        };
        let mut basis = Self(Vec::new());
        match first.tile.registration {
            Registration::Ideal => {}
            Registration::Reference(_) => {
                for step in STEPS {
                    let changes = tiles.iter().map(|t| change(t, step));
                    basis.add(changes.collect::<Vec<_>>().concat());
                }
            }
            Registration::Centroid => {
                for (index, _) in tiles.iter().enumerate() {
                    for step in STEPS {
                        let changes = tiles.iter().enumerate().map(|(other, t)| {
                            if other == index {
                                change(t, step)
                            } else {
                                vec![0.0; t.prediction.len()]
                            }
                        });
                        basis.add(changes.collect::<Vec<_>>().concat());
                    }
                }
            }
        }
        basis
    }

    /// Subtracts from `values` their projection onto the basis.
    pub(super) fn remove_from(&self, values: &mut [f64]) {
        for direction in &self.0 {
            let along: f64 = direction.iter().zip(&*values).map(|(a, b)| a * b).sum();
            for (value, d) in values.iter_mut().zip(direction) {
                *value -= along * d;
            }
        }
    }

    /// Adds the part of `vector` that is orthogonal to the basis.
    fn add(&mut self, mut vector: Vec<f64>) {
        self.remove_from(&mut vector);
        let norm = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
        if norm > 0.0 {
            vector.iter_mut().for_each(|v| *v /= norm);
            self.0.push(vector);
        }
    }
}

/// Shifts along x and y.
const STEPS: [(i64, i64); 2] = [(1, 0), (0, 1)];

/// Returns the change of a predicted tile by a shift along `step`.
fn change(predicted: &PredictedTile, step: (i64, i64)) -> Vec<f64> {
    let mut change = central_difference(predicted.prediction, predicted.tile.size, step);
    for (index, value) in change.iter_mut().enumerate() {
        if predicted.tile.counts.get(index) == Some(&false) {
            *value = 0.0;
        } else {
            *value *= predicted.scale;
        }
    }
    change
}
