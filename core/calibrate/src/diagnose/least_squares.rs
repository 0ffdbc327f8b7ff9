//! Nonlinear least squares of a hypothesis by Levenberg-Marquardt, with normal equations per fold.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use super::prediction::{TilePredictor, central_difference};
use super::tiles::{FOLDS, TileData};
use seidel_optics::psf::pupil::Detail;

/// Noise contribution at which a tile's weight has fallen to a half.
const NOISE_WEIGHT_KNEE: f64 = 3e-3;

/// Returns the weight of a tile, which falls with its noise.
pub(super) fn weight(tile: &TileData) -> f64 {
    NOISE_WEIGHT_KNEE / (NOISE_WEIGHT_KNEE + tile.noise)
}

/// A hypothesis and the tiles to fit.
pub(super) struct Problem<'a> {
    hypothesis: &'a Hypothesis,
    tiles: &'a [&'a TileData],
    detail: Detail,
}

/// Gauss-Newton normal equations of one fold.
#[derive(Debug, Clone)]
pub(super) struct NormalEquations {
    /// Sum of J'J.
    pub(super) matrix: DMatrix<f64>,
    /// Sum of J'r.
    pub(super) right: DVector<f64>,
    /// Sum of r'r.
    pub(super) cost: f64,
    /// Sum over tiles of the outer product of J'r, for the sandwich covariance.
    pub(super) scores: DMatrix<f64>,
}

/// Normal equations of a hypothesis at some values.
#[derive(Debug, Clone)]
pub(super) struct FoldEquations {
    /// Normal equations of each fold.
    pub(super) folds: Vec<NormalEquations>,
}

impl FoldEquations {
    /// Returns the sum over all folds except `left_out`.
    pub(super) fn total(&self, left_out: Option<usize>) -> NormalEquations {
        let size = self.folds[0].right.len();
        let mut sum = NormalEquations {
            matrix: DMatrix::zeros(size, size),
            right: DVector::zeros(size),
            cost: 0.0,
            scores: DMatrix::zeros(size, size),
        };
        for (fold, normal) in self.folds.iter().enumerate() {
            if Some(fold) != left_out {
                sum.matrix += &normal.matrix;
                sum.right += &normal.right;
                sum.cost += normal.cost;
                sum.scores += &normal.scores;
            }
        }
        sum
    }
}

/// Parameter values with their cost.
#[derive(Debug, Clone)]
pub(super) struct LocalMinimum {
    pub(super) theta: Vec<f64>,
    /// Weighted sum of gaps.
    pub(super) cost: f64,
}

impl<'a> Problem<'a> {
    pub(super) fn new(
        hypothesis: &'a Hypothesis,
        tiles: &'a [&'a TileData],
        detail: Detail,
    ) -> Self {
        Self {
            hypothesis,
            tiles,
            detail,
        }
    }

    /// Returns the gap of every tile at `theta`.
    pub(super) fn gaps(&self, theta: &[f64]) -> Vec<f64> {
        let by_channel = self.by_channel(theta);
        self.tiles
            .par_iter()
            .map_init(
                || (TilePredictor::default(), Vec::new()),
                |(predictor, picture), tile| {
                    let values = &by_channel[tile.of_lens];
                    predictor.predict(self.hypothesis, values, tile, self.detail, picture);
                    let mut residual = residual(tile, picture);
                    if !tile.has_ideal {
                        ShiftBasis::of(tile, picture).remove(&mut residual);
                    }
                    residual.iter().map(|r| r * r).sum::<f64>() / tile.norm
                },
            )
            .collect()
    }

    /// Returns the weighted sum of gaps at `theta`.
    pub(super) fn cost(&self, theta: &[f64]) -> f64 {
        let gaps = self.gaps(theta);
        let terms = gaps.iter().zip(self.tiles).map(|(g, t)| g * weight(t));
        terms.sum()
    }

    fn by_channel(&self, theta: &[f64]) -> Vec<Vec<Vec<f64>>> {
        (0..self.hypothesis.channels())
            .map(|channel| self.hypothesis.values(theta, channel))
            .collect()
    }

    /// Returns the normal equations at `theta`, by one-sided differences.
    pub(super) fn linear(&self, theta: &[f64]) -> FoldEquations {
        let slots = &self.hypothesis.slots;
        let here = self.by_channel(theta);
        // One difference per free parameter, directed inwards at bounds.
        let stepped: Vec<(f64, Vec<Vec<Vec<f64>>>)> = slots
            .iter()
            .enumerate()
            .map(|(k, slot)| {
                let h = STEP * slot.step;
                let h = if theta[k] + h > slot.most { -h } else { h };
                let mut there = theta.to_vec();
                there[k] += h;
                (h, self.by_channel(&there))
            })
            .collect();
        let terms: Vec<(usize, Vec<usize>, NormalEquations)> = self
            .tiles
            .par_iter()
            .map_init(
                || (TilePredictor::default(), Vec::new(), Vec::new()),
                |(predictor, picture, moved), tile| {
                    let channel = tile.of_lens;
                    let hypothesis = self.hypothesis;
                    predictor.predict(hypothesis, &here[channel], tile, self.detail, picture);
                    let mut residual = residual(tile, picture);
                    let own: Vec<usize> = (0..slots.len())
                        .filter(|k| hypothesis.concerns(*k, channel))
                        .collect();
                    let mut columns: Vec<Vec<f64>> = own
                        .iter()
                        .map(|&k| {
                            let (h, values) = &stepped[k];
                            predictor.predict(
                                hypothesis,
                                &values[channel],
                                tile,
                                self.detail,
                                moved,
                            );
                            let pixels = moved.iter().zip(&*picture);
                            pixels.map(|(there, here)| (there - here) / h).collect()
                        })
                        .collect();
                    if !tile.has_ideal {
                        let shifts = ShiftBasis::of(tile, picture);
                        shifts.remove(&mut residual);
                        columns.iter_mut().for_each(|c| shifts.remove(c));
                    }
                    let scale = weight(tile) / tile.norm;
                    let dot = |a: &[f64], b: &[f64]| {
                        scale * a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>()
                    };
                    let n = own.len();
                    let mut matrix = DMatrix::zeros(n, n);
                    for i in 0..n {
                        for j in 0..=i {
                            let product = dot(&columns[i], &columns[j]);
                            matrix[(i, j)] = product;
                            matrix[(j, i)] = product;
                        }
                    }
                    let right = DVector::from_fn(n, |i, _| dot(&columns[i], &residual));
                    let cost = dot(&residual, &residual);
                    let normal = NormalEquations {
                        scores: &right * right.transpose(),
                        matrix,
                        right,
                        cost,
                    };
                    (tile.fold, own, normal)
                },
            )
            .collect();
        let empty = NormalEquations {
            matrix: DMatrix::zeros(slots.len(), slots.len()),
            right: DVector::zeros(slots.len()),
            cost: 0.0,
            scores: DMatrix::zeros(slots.len(), slots.len()),
        };
        let mut folds = vec![empty; FOLDS];
        for (fold, own, normal) in &terms {
            let sum = &mut folds[*fold];
            for (i, &row) in own.iter().enumerate() {
                sum.right[row] += normal.right[i];
                for (j, &column) in own.iter().enumerate() {
                    sum.matrix[(row, column)] += normal.matrix[(i, j)];
                    sum.scores[(row, column)] += normal.scores[(i, j)];
                }
            }
            sum.cost += normal.cost;
        }
        FoldEquations { folds }
    }

    /// Minimises the cost from `from` for at most `iterations` steps, until the relative decrease is below
    /// `enough`.
    pub(super) fn descend(&self, from: &[f64], iterations: usize, enough: f64) -> LocalMinimum {
        let slots = &self.hypothesis.slots;
        let mut theta = from.to_vec();
        if slots.is_empty() {
            return LocalMinimum {
                cost: self.cost(&theta),
                theta,
            };
        }
        let mut damping = 1e-3;
        let mut cost = f64::INFINITY;
        for _ in 0..iterations {
            let normal = self.linear(&theta).total(None);
            cost = normal.cost;
            let mut better = None;
            for _ in 0..4 {
                let trial = bounded_step(&normal, &theta, slots, damping);
                let there = self.cost(&trial);
                if there < cost {
                    better = Some((trial, there));
                    damping = (damping * 0.2_f64).max(1e-7);
                    break;
                }
                damping *= 8.0;
            }
            let Some((trial, there)) = better else {
                break;
            };
            let gained = cost - there;
            theta = trial;
            cost = there;
            if gained < enough * cost {
                break;
            }
        }
        LocalMinimum { theta, cost }
    }
}

/// Step of the differences, in units of the parameter's own step.
const STEP: f64 = 0.1;

/// Returns `theta` after a damped step. Parameters at a bound are fixed if the step leads beyond it (active
/// set).
pub(super) fn bounded_step(
    normal: &NormalEquations,
    theta: &[f64],
    slots: &[super::hypothesis::Slot],
    damping: f64,
) -> Vec<f64> {
    let n = theta.len();
    let mut held = vec![false; n];
    let mut trial = theta.to_vec();
    for _ in 0..=n {
        let free: Vec<usize> = (0..n).filter(|k| !held[*k]).collect();
        if free.is_empty() {
            break;
        }
        let delta = solve(normal, &free, slots, damping);
        let mut again = false;
        for (&k, d) in free.iter().zip(delta.iter()) {
            let slot = &slots[k];
            let to = theta[k] + d;
            let at_limit =
                (theta[k] <= slot.least && *d < 0.0) || (theta[k] >= slot.most && *d > 0.0);
            if at_limit {
                held[k] = true;
                again = true;
            }
            trial[k] = to.clamp(slot.least, slot.most);
        }
        if !again {
            break;
        }
        trial = theta.to_vec();
    }
    trial
}

/// Solves the damped normal equations for the parameters `free`. A small ridge keeps parameters without
/// influence in place.
fn solve(
    normal: &NormalEquations,
    free: &[usize],
    slots: &[super::hypothesis::Slot],
    damping: f64,
) -> DVector<f64> {
    let n = free.len();
    let mut matrix = DMatrix::from_fn(n, n, |i, j| normal.matrix[(free[i], free[j])]);
    let right = DVector::from_fn(n, |i, _| normal.right[free[i]]);
    let mean = normal.matrix.diagonal().sum() / normal.right.len() as f64;
    for i in 0..n {
        let step = slots[free[i]].step;
        let least = 1e-9 * normal.cost.max(1e-12) / (step * step);
        matrix[(i, i)] += damping * matrix[(i, i)] + least + 1e-14 * mean;
    }
    matrix
        .clone()
        .cholesky()
        .map(|c| c.solve(&right))
        .or_else(|| matrix.lu().solve(&right))
        .unwrap_or_else(|| DVector::zeros(n))
}

/// Returns observed minus predicted.
fn residual(tile: &TileData, picture: &[f64]) -> Vec<f64> {
    tile.light.iter().zip(picture).map(|(o, p)| o - p).collect()
}

/// Orthonormal basis of the image changes caused by a shift. It is projected out of residuals of tiles
/// without an ideal position.
struct ShiftBasis([Vec<f64>; 2]);

impl ShiftBasis {
    fn of(tile: &TileData, picture: &[f64]) -> Self {
        let mut pair = [(1, 0), (0, 1)].map(|step| central_difference(picture, tile.size, step));
        for (index, counts) in tile.counts.iter().enumerate() {
            if !counts {
                pair[0][index] = 0.0;
                pair[1][index] = 0.0;
            }
        }
        let [first, second] = &mut pair;
        normalise(first);
        let along = first.iter().zip(&*second).map(|(a, b)| a * b).sum::<f64>();
        second
            .iter_mut()
            .zip(&*first)
            .for_each(|(b, a)| *b -= along * a);
        normalise(second);
        Self(pair)
    }

    fn remove(&self, values: &mut [f64]) {
        for shift in &self.0 {
            let along = shift.iter().zip(&*values).map(|(a, b)| a * b).sum::<f64>();
            values
                .iter_mut()
                .zip(shift)
                .for_each(|(v, s)| *v -= along * s);
        }
    }
}

fn normalise(values: &mut [f64]) {
    let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    if norm > 0.0 {
        values.iter_mut().for_each(|v| *v /= norm);
    }
}
