//! The values of a hypothesis that leave the least gap, by Levenberg-Marquardt.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::Hypothesis;
use super::picture::{Easel, slope};
use super::seen::{FOLDS, Seen};
use seidel_optics::psf::pupil::Detail;

/// Gap below which tiles count less the noisier they are.
const NOISE_KNEE: f64 = 3e-3;

/// How much a tile counts.
pub(super) fn weight(seen: &Seen) -> f64 {
    NOISE_KNEE / (NOISE_KNEE + seen.noise)
}

/// A hypothesis, and the tiles that it is to explain.
pub(super) struct Problem<'a> {
    hypothesis: &'a Hypothesis,
    tiles: &'a [&'a Seen],
    detail: Detail,
}

/// Normal equations of one fold.
#[derive(Debug, Clone)]
pub(super) struct Normal {
    /// Sum of J'J.
    pub(super) matrix: DMatrix<f64>,
    /// Sum of J'r.
    pub(super) right: DVector<f64>,
    /// Sum of r'r.
    pub(super) cost: f64,
    /// Sum over tiles of the outer product of each one's J'r: how tiles differ in what they ask for.
    pub(super) scores: DMatrix<f64>,
}

/// What is known of a hypothesis at some values.
#[derive(Debug, Clone)]
pub(super) struct Linear {
    /// One a fold.
    pub(super) folds: Vec<Normal>,
}

impl Linear {
    /// All folds but `left_out`.
    pub(super) fn total(&self, left_out: Option<usize>) -> Normal {
        let size = self.folds[0].right.len();
        let mut sum = Normal {
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

/// Values and how well they do.
#[derive(Debug, Clone)]
pub(super) struct Fitted {
    pub(super) theta: Vec<f64>,
    /// Weighted sum of gaps.
    pub(super) cost: f64,
}

impl<'a> Problem<'a> {
    pub(super) fn new(hypothesis: &'a Hypothesis, tiles: &'a [&'a Seen], detail: Detail) -> Self {
        Self {
            hypothesis,
            tiles,
            detail,
        }
    }

    /// The gap of every tile at `theta`.
    pub(super) fn gaps(&self, theta: &[f64]) -> Vec<f64> {
        let by_channel = self.by_channel(theta);
        self.tiles
            .par_iter()
            .map_init(
                || (Easel::default(), Vec::new()),
                |(easel, picture), seen| {
                    let values = &by_channel[seen.of_lens];
                    easel.predict(self.hypothesis, values, seen, self.detail, picture);
                    let mut residual = residual(seen, picture);
                    if !seen.placed {
                        Shifts::of(seen, picture).take_off(&mut residual);
                    }
                    residual.iter().map(|r| r * r).sum::<f64>() / seen.norm
                },
            )
            .collect()
    }

    /// Weighted sum of gaps at `theta`.
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

    /// Normal equations at `theta`, by differences.
    pub(super) fn linear(&self, theta: &[f64]) -> Linear {
        let slots = &self.hypothesis.slots;
        let here = self.by_channel(theta);
        // A step of each slot, inwards from limits.
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
        let terms: Vec<(usize, Vec<usize>, Normal)> = self
            .tiles
            .par_iter()
            .map_init(
                || (Easel::default(), Vec::new(), Vec::new()),
                |(easel, picture, moved), seen| {
                    let channel = seen.of_lens;
                    let hypothesis = self.hypothesis;
                    easel.predict(hypothesis, &here[channel], seen, self.detail, picture);
                    let mut residual = residual(seen, picture);
                    let own: Vec<usize> = (0..slots.len())
                        .filter(|k| hypothesis.concerns(*k, channel))
                        .collect();
                    let mut columns: Vec<Vec<f64>> = own
                        .iter()
                        .map(|&k| {
                            let (h, values) = &stepped[k];
                            easel.predict(hypothesis, &values[channel], seen, self.detail, moved);
                            let pixels = moved.iter().zip(&*picture);
                            pixels.map(|(there, here)| (there - here) / h).collect()
                        })
                        .collect();
                    if !seen.placed {
                        let shifts = Shifts::of(seen, picture);
                        shifts.take_off(&mut residual);
                        columns.iter_mut().for_each(|c| shifts.take_off(c));
                    }
                    let scale = weight(seen) / seen.norm;
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
                    let normal = Normal {
                        scores: &right * right.transpose(),
                        matrix,
                        right,
                        cost,
                    };
                    (seen.fold, own, normal)
                },
            )
            .collect();
        let empty = Normal {
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
        Linear { folds }
    }

    /// Descends from `from` for at most `iterations` steps, until one gains less than the share `enough`.
    pub(super) fn descend(&self, from: &[f64], iterations: usize, enough: f64) -> Fitted {
        let slots = &self.hypothesis.slots;
        let mut theta = from.to_vec();
        if slots.is_empty() {
            return Fitted {
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
        Fitted { theta, cost }
    }
}

/// Differences are taken over this share of a parameter's step.
const STEP: f64 = 0.1;

/// The damped step from `theta`, numbers at their limits held where the step would lead beyond.
pub(super) fn bounded_step(
    normal: &Normal,
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

/// Solves the damped normal equations for the numbers `free`; a little is added so that numbers which
/// change nothing stay where they are.
fn solve(
    normal: &Normal,
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

/// Observed less predicted.
fn residual(seen: &Seen, picture: &[f64]) -> Vec<f64> {
    seen.light.iter().zip(picture).map(|(o, p)| o - p).collect()
}

/// How a picture changes when it is shifted: an orthonormal pair. Where a point's ideal position is not
/// known its picture's place says nothing, and this is taken off all that is compared.
struct Shifts([Vec<f64>; 2]);

impl Shifts {
    fn of(seen: &Seen, picture: &[f64]) -> Self {
        let mut pair = [(1, 0), (0, 1)].map(|step| slope(picture, seen.size, step));
        for (index, counts) in seen.counts.iter().enumerate() {
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

    fn take_off(&self, values: &mut [f64]) {
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
