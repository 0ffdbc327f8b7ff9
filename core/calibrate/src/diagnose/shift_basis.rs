//! Image changes that shifts of unknown size cause: they are projected out of residuals.

use nalgebra::{Matrix2, Vector2};

use super::prediction::central_difference;
use super::registration::Registration;
use super::tiles::TileData;
use seidel_optics::numeric::dot;

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
            let along = dot(direction, values);
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

/// Returns the least-squares shift of each of the `tiles` of one observation, px: the same for all if they are placed by their
/// reference channel. `None` if the position is stated, or if the tiles do not show a shift.
pub(super) fn least_squares_shifts(tiles: &[PredictedTile]) -> Option<Vec<[f64; 2]>> {
    let common = match tiles.first()?.tile.registration {
        Registration::Ideal => return None,
        Registration::Reference(_) => true,
        Registration::Centroid => false,
    };
    let equations = tiles.iter().map(ShiftEquations::of);
    if common {
        let sum = equations.reduce(ShiftEquations::plus)?;
        return Some(vec![sum.shift_px()?; tiles.len()]);
    }
    equations.map(|e| e.shift_px()).collect()
}

/// Normal equations of a shift.
struct ShiftEquations {
    matrix: Matrix2<f64>,
    right: Vector2<f64>,
}

impl ShiftEquations {
    fn of(predicted: &PredictedTile) -> Self {
        let [x, y] = STEPS.map(|step| change(predicted, step));
        let mut sums = Self {
            matrix: Matrix2::zeros(),
            right: Vector2::zeros(),
        };
        let residual = predicted.tile.residual(predicted.prediction);
        for ((x, y), r) in x.iter().zip(&y).zip(residual) {
            // A shift by s changes the picture by -s times its gradient.
            let gradient = Vector2::new(-x, -y);
            sums.matrix += gradient * gradient.transpose();
            sums.right += gradient * (r * predicted.scale);
        }
        sums
    }

    fn plus(self, other: Self) -> Self {
        Self {
            matrix: self.matrix + other.matrix,
            right: self.right + other.right,
        }
    }

    fn shift_px(&self) -> Option<[f64; 2]> {
        Some((self.matrix.try_inverse()? * self.right).into())
    }
}

/// Shifts along x and y.
const STEPS: [(i64, i64); 2] = [(1, 0), (0, 1)];

/// Returns the change of a predicted tile by a shift along `step`.
fn change(predicted: &PredictedTile, step: (i64, i64)) -> Vec<f64> {
    let mut change = central_difference(predicted.prediction, predicted.tile.size, step);
    predicted.tile.mask(&mut change);
    change.iter_mut().for_each(|v| *v *= predicted.scale);
    change
}
