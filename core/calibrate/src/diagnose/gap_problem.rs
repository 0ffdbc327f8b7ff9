//! The least-squares problem of a hypothesis: the gaps of its tiles, with normal equations per fold.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::hypothesis::{Hypothesis, Slot};
use super::prediction::{Linearisation, ParameterStep, PlacedTile, TilePredictor};
use super::shift_basis::{PredictedTile, ShiftBasis, least_squares_shifts};
use super::tiles::{FOLDS, TileData};
use crate::least_squares::{Damping, LeastSquares, NormalEquations, Stop, Trial, minimise};
use seidel_optics::numeric::dot;
use seidel_optics::psf::pupil::Detail;

/// Noise contribution at which a tile's weight has fallen to a half.
const NOISE_WEIGHT_KNEE: f64 = 3e-3;
/// Step of the one-sided differences, in units of the parameter's own step.
const DIFFERENCE_STEP: f64 = 0.1;
/// Ridge in units of the cost over the square of the parameter's own step. It keeps parameters without
/// influence in place.
const RIDGE: f64 = 1e-9;
/// Ridge relative to the mean diagonal element of the normal matrix, against rounding errors.
const ROUNDING_RIDGE: f64 = 1e-14;
/// Lower bound of the cost in the ridge.
const MIN_RIDGE_COST: f64 = 1e-12;
/// Most moves of the tiles of an observation by their unknown shift, the size of one, px, and the shift that the projection alone
/// describes, px. Drafts leave tiles where they are: the best effect has placed them.
const MAX_MOVES: usize = 3;
const MAX_MOVE_PX: f64 = 0.5;
const SMALL_SHIFT_PX: f64 = 0.03;
const DAMPING: Damping = Damping {
    increase: 8.0,
    least: 1e-7,
    max_tries: 4,
    negligible_change: 0.0,
};

/// Returns the weight of a tile, which falls with its noise.
pub(super) fn weight(tile: &TileData) -> f64 {
    NOISE_WEIGHT_KNEE / (NOISE_WEIGHT_KNEE + tile.noise)
}

/// Returns the weighted mean gap that `nothing` leaves of `tiles`, less noise.
pub(super) fn mean_gap(nothing: &Hypothesis, tiles: &[TileData]) -> f64 {
    let tiles: Vec<&TileData> = tiles.iter().collect();
    let gaps = GapProblem::new(nothing, &tiles, Detail::COARSE).gaps(&[]);
    let (mut total, mut excess) = (0.0, 0.0);
    for (gap, tile) in gaps.iter().zip(&tiles) {
        total += weight(tile);
        excess += weight(tile) * (gap - tile.noise);
    }
    excess / total
}

/// A hypothesis and the tiles to fit.
pub(super) struct GapProblem<'a> {
    hypothesis: &'a Hypothesis,
    tiles: &'a [&'a TileData],
    detail: Detail,
}

/// Sums over tiles that make up the normal equations.
#[derive(Debug, Clone)]
pub(super) struct NormalSums {
    /// Sum of J'J.
    pub(super) matrix: DMatrix<f64>,
    /// Sum of J'r.
    pub(super) right: DVector<f64>,
    /// Sum of r'r.
    pub(super) cost: f64,
    /// Sum over observations of the outer product of J'r, for the sandwich covariance.
    pub(super) scores: DMatrix<f64>,
}

impl NormalSums {
    fn zero(size: usize) -> Self {
        Self {
            matrix: DMatrix::zeros(size, size),
            right: DVector::zeros(size),
            cost: 0.0,
            scores: DMatrix::zeros(size, size),
        }
    }

    /// Returns where the damped step from `theta` leads, with the cost there by the quadratic approximation.
    pub(super) fn step(&self, theta: &[f64], slots: &[Slot], lambda: f64) -> LocalMinimum {
        let there = damped_update(self.clone(), theta, slots, lambda);
        let delta = DVector::from_fn(theta.len(), |k, _| there[k] - theta[k]);
        LocalMinimum {
            cost: self.cost_after(&delta),
            theta: there,
        }
    }

    /// Returns the cost after the change `delta` of the parameters, by the quadratic approximation.
    pub(super) fn cost_after(&self, delta: &DVector<f64>) -> f64 {
        self.cost - 2.0 * self.right.dot(delta) + (&self.matrix * delta).dot(delta)
    }

    /// Returns the normal equations for the parameters `slots`.
    fn equations(self, slots: &[Slot]) -> NormalEquations {
        let mean = self.matrix.diagonal().sum() / self.right.len() as f64;
        let cost = self.cost.max(MIN_RIDGE_COST);
        let ridge = |slot: &Slot| RIDGE * cost / (slot.step * slot.step) + ROUNDING_RIDGE * mean;
        NormalEquations {
            ridge: DVector::from_iterator(slots.len(), slots.iter().map(ridge)),
            ..NormalEquations::new(self.matrix, self.right, self.cost)
        }
    }
}

/// Sums of a hypothesis at some parameter values, by fold.
#[derive(Debug, Clone)]
pub(super) struct FoldSums {
    pub(super) folds: Vec<NormalSums>,
    /// Gap of every tile.
    pub(super) gaps: Vec<f64>,
}

impl FoldSums {
    /// Returns the sum over all folds except `left_out`.
    pub(super) fn total(&self, left_out: Option<usize>) -> NormalSums {
        let mut total = NormalSums::zero(self.folds[0].right.len());
        for (fold, sums) in self.folds.iter().enumerate() {
            if Some(fold) != left_out {
                total.matrix += &sums.matrix;
                total.right += &sums.right;
                total.cost += sums.cost;
                total.scores += &sums.scores;
            }
        }
        total
    }
}

/// Parameter values with their cost.
#[derive(Debug, Clone)]
pub(super) struct LocalMinimum {
    pub(super) theta: Vec<f64>,
    /// Weighted sum of gaps.
    pub(super) cost: f64,
}

impl<'a> GapProblem<'a> {
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
        let gaps: Vec<Vec<f64>> = self
            .observations()
            .par_iter()
            .map_init(TilePredictor::default, |predictor, tiles| {
                let (_, pictures) = self.align(predictor, tiles, &by_channel);
                let stack = Stack::new(tiles, &pictures);
                stack.gaps(&stack.residual())
            })
            .collect();
        gaps.concat()
    }

    /// Returns the tiles of each observation.
    fn observations(&self) -> Vec<&'a [&'a TileData]> {
        let same = |a: &&TileData, b: &&TileData| a.observation == b.observation;
        self.tiles.chunk_by(same).collect()
    }

    /// Returns the prediction of each of `tiles`.
    fn pictures(
        &self,
        predictor: &mut TilePredictor,
        tiles: &[PlacedTile],
        by_channel: &[Vec<Vec<f64>>],
    ) -> Vec<Vec<f64>> {
        let predict = |placed: &PlacedTile| {
            let mut picture = Vec::new();
            let values = &by_channel[placed.tile.of_lens];
            predictor.predict(self.hypothesis, values, *placed, self.detail, &mut picture);
            picture
        };
        tiles.iter().map(predict).collect()
    }

    /// Returns the shifts of the tiles of an observation that are too large for the projection alone; `None` where there are none.
    fn moves(&self, stack: &Stack) -> Option<Vec<[f64; 2]>> {
        if self.detail == Detail::DRAFT {
            return None;
        }
        let shifts = least_squares_shifts(&stack.tiles)?;
        let is_large = shifts.iter().any(|[x, y]| x.hypot(*y) > SMALL_SHIFT_PX);
        is_large.then_some(shifts)
    }

    /// Returns the `tiles` of one observation with their predictions, moved by their unknown shifts to where they agree best with
    /// the pixels (Gauss-Newton). The projection of residuals alone would not do: it is linear in the shift, and a PSF as narrow
    /// as a pixel is not.
    fn align<'t>(
        &self,
        predictor: &mut TilePredictor,
        tiles: &[&'t TileData],
        by_channel: &[Vec<Vec<f64>>],
    ) -> (Vec<PlacedTile<'t>>, Vec<Vec<f64>>) {
        let mut placed: Vec<PlacedTile> = tiles.iter().map(|t| PlacedTile::from(*t)).collect();
        let mut pictures = self.pictures(predictor, &placed, by_channel);
        let mut left = None;
        for _ in 0..MAX_MOVES {
            let stack = Stack::new(tiles, &pictures);
            let Some(shifts) = self.moves(&stack) else {
                break;
            };
            let before = *left.get_or_insert_with(|| energy(&stack.residual()));
            let mut moved = placed.clone();
            for (tile, [x, y]) in moved.iter_mut().zip(shifts) {
                let part = (MAX_MOVE_PX / x.hypot(y)).min(1.0);
                tile.offset = [tile.offset[0] + part * x, tile.offset[1] + part * y];
            }
            let there = self.pictures(predictor, &moved, by_channel);
            let after = energy(&Stack::new(tiles, &there).residual());
            if after >= before {
                break;
            }
            (placed, pictures, left) = (moved, there, Some(after));
        }
        (placed, pictures)
    }

    /// Returns the weighted sum of gaps at `theta`.
    pub(super) fn gap_sum(&self, theta: &[f64]) -> f64 {
        let gaps = self.gaps(theta);
        let terms = gaps.iter().zip(self.tiles).map(|(g, t)| g * weight(t));
        terms.sum()
    }

    fn by_channel(&self, theta: &[f64]) -> Vec<Vec<Vec<f64>>> {
        (0..self.hypothesis.channels())
            .map(|channel| self.hypothesis.values(theta, channel))
            .collect()
    }

    /// Returns the normal sums of every fold at `theta`.
    pub(super) fn linear(&self, theta: &[f64]) -> FoldSums {
        let slots = &self.hypothesis.slots;
        let here = self.by_channel(theta);
        // One difference per free parameter, directed inwards at bounds.
        let stepped: Vec<(f64, Vec<Vec<Vec<f64>>>)> = slots
            .iter()
            .enumerate()
            .map(|(k, slot)| {
                let h = DIFFERENCE_STEP * slot.step;
                let h = if theta[k] + h > slot.most { -h } else { h };
                let mut there = theta.to_vec();
                there[k] += h;
                (h, self.by_channel(&there))
            })
            .collect();
        let sums: Vec<(NormalSums, Vec<f64>)> = self
            .observations()
            .par_iter()
            .map_init(TilePredictor::default, |predictor, tiles| {
                let linearise = |predictor: &mut TilePredictor, placed: &[PlacedTile]| {
                    let each = placed.iter().map(|placed| {
                        let of_lens = placed.tile.of_lens;
                        let steps: Vec<ParameterStep> = (stepped.iter().enumerate())
                            .filter(|(k, _)| self.hypothesis.concerns(*k, of_lens))
                            .map(|(_, (size, values))| ParameterStep {
                                size: *size,
                                values: &values[of_lens],
                            })
                            .collect();
                        let values = &here[of_lens];
                        predictor.linearise(self.hypothesis, values, &steps, *placed, self.detail)
                    });
                    each.collect::<Vec<Linearisation>>()
                };
                let placed: Vec<PlacedTile> = tiles.iter().map(|t| (*t).into()).collect();
                let mut linearised = linearise(predictor, &placed);
                let pictures: Vec<&[f64]> = linearised.iter().map(|l| &l.picture[..]).collect();
                if self.moves(&Stack::new(tiles, &pictures)).is_some() {
                    let (placed, _) = self.align(predictor, tiles, &here);
                    linearised = linearise(predictor, &placed);
                }
                let (pictures, mut rates): (Vec<_>, Vec<_>) = (linearised.into_iter())
                    .map(|l| (l.picture, l.rates.into_iter()))
                    .unzip();
                let stack = Stack::new(tiles, &pictures);
                let columns: Vec<Vec<f64>> = (0..slots.len())
                    .map(|k| {
                        let own = (tiles.iter().zip(&pictures)).zip(&mut rates);
                        let own = own.map(|((tile, picture), rates)| {
                            if self.hypothesis.concerns(k, tile.of_lens) {
                                rates.next().expect("one image for each step")
                            } else {
                                vec![0.0; picture.len()]
                            }
                        });
                        stack.column(own.collect())
                    })
                    .collect();
                let residual = stack.residual();
                let n = columns.len();
                let mut matrix = DMatrix::zeros(n, n);
                for i in 0..n {
                    for j in 0..=i {
                        let product = dot(&columns[i], &columns[j]);
                        matrix[(i, j)] = product;
                        matrix[(j, i)] = product;
                    }
                }
                let right = DVector::from_fn(n, |i, _| dot(&columns[i], &residual));
                let gaps = stack.gaps(&residual);
                let sums = NormalSums {
                    scores: &right * right.transpose(),
                    cost: energy(&residual),
                    matrix,
                    right,
                };
                (sums, gaps)
            })
            .collect();
        let mut folds = vec![NormalSums::zero(slots.len()); FOLDS];
        for ((sums, _), tiles) in sums.iter().zip(self.observations()) {
            let total = &mut folds[tiles[0].fold];
            total.matrix += &sums.matrix;
            total.right += &sums.right;
            total.cost += sums.cost;
            total.scores += &sums.scores;
        }
        let gaps: Vec<Vec<f64>> = sums.into_iter().map(|(_, gaps)| gaps).collect();
        FoldSums {
            folds,
            gaps: gaps.concat(),
        }
    }

    /// Minimises the cost from `from` by Levenberg-Marquardt for at most `max_iterations`, until a step lowers
    /// the cost by less than `min_decrease` of the new cost.
    pub(super) fn descend(
        &self,
        from: &[f64],
        max_iterations: usize,
        min_decrease: f64,
    ) -> LocalMinimum {
        if from.is_empty() {
            return LocalMinimum {
                cost: self.gap_sum(from),
                theta: Vec::new(),
            };
        }
        // The same threshold relative to the cost before the step.
        let stop = Stop::at_decrease(max_iterations, min_decrease / (1.0 + min_decrease));
        let found = minimise(self, from.to_vec(), DAMPING, stop);
        LocalMinimum {
            theta: found.point,
            cost: found.cost,
        }
    }
}

impl LeastSquares for GapProblem<'_> {
    type Point = Vec<f64>;

    fn linearise(&self, theta: &Vec<f64>) -> NormalEquations {
        let total = self.linear(theta).total(None);
        total.equations(&self.hypothesis.slots)
    }

    fn trial(&self, theta: &Vec<f64>, equations: &NormalEquations) -> Option<Trial<Vec<f64>>> {
        let slots = &self.hypothesis.slots;
        let step = active_set_step(equations, theta, slots)?;
        let moved = clamped(theta, &step, slots);
        let cost = self.gap_sum(&moved);
        Some(Trial::new(moved, cost, &step))
    }
}

/// Returns `theta` after the damped step that `sums` ask for; unchanged where they have no solution.
pub(super) fn damped_update(
    sums: NormalSums,
    theta: &[f64],
    slots: &[Slot],
    lambda: f64,
) -> Vec<f64> {
    let equations = NormalEquations {
        lambda,
        ..sums.equations(slots)
    };
    active_set_step(&equations, theta, slots)
        .map_or_else(|| theta.to_vec(), |step| clamped(theta, &step, slots))
}

/// Returns the damped step. Parameters at a bound are fixed if the step leads beyond it (active set).
fn active_set_step(
    equations: &NormalEquations,
    theta: &[f64],
    slots: &[Slot],
) -> Option<DVector<f64>> {
    let mut free = vec![true; theta.len()];
    loop {
        let step = equations.damped_step(|k| free[k])?;
        let is_blocked = |k: usize| {
            (theta[k] <= slots[k].least && step[k] < 0.0)
                || (theta[k] >= slots[k].most && step[k] > 0.0)
        };
        let blocked: Vec<usize> = (0..theta.len()).filter(|&k| is_blocked(k)).collect();
        if blocked.is_empty() {
            return Some(step);
        }
        blocked.iter().for_each(|&k| free[k] = false);
    }
}

/// Returns `theta` after `step`, within the bounds.
fn clamped(theta: &[f64], step: &DVector<f64>, slots: &[Slot]) -> Vec<f64> {
    let moved = theta.iter().zip(step.iter()).map(|(t, d)| t + d);
    let within = moved
        .zip(slots)
        .map(|(t, slot)| t.clamp(slot.least, slot.most));
    within.collect()
}

/// The pixels of all tiles of an observation, one tile after the other, each times the root of weight over squared norm.
struct Stack<'a> {
    tiles: Vec<PredictedTile<'a>>,
    shifts: ShiftBasis,
}

impl<'a> Stack<'a> {
    fn new<P: AsRef<[f64]>>(tiles: &[&'a TileData], pictures: &'a [P]) -> Self {
        let predicted = tiles
            .iter()
            .zip(pictures)
            .map(|(tile, picture)| PredictedTile {
                tile,
                prediction: picture.as_ref(),
                scale: (weight(tile) / tile.norm).sqrt(),
            });
        let tiles: Vec<PredictedTile> = predicted.collect();
        Self {
            shifts: ShiftBasis::new(&tiles),
            tiles,
        }
    }

    /// Returns the residuals without those of unknown shifts and fluxes.
    fn residual(&self) -> Vec<f64> {
        let parts = self.tiles.iter().map(|t| {
            let mut residual = t.tile.residual(t.prediction);
            residual.iter_mut().for_each(|r| *r *= t.scale);
            residual
        });
        let mut stacked = parts.collect::<Vec<_>>().concat();
        self.shifts.remove_from(&mut stacked);
        stacked
    }

    /// Returns the derivatives `rates` of the predictions, without those of unknown shifts and fluxes.
    fn column(&self, rates: Vec<Vec<f64>>) -> Vec<f64> {
        let parts = self.tiles.iter().zip(rates).map(|(t, mut rate)| {
            t.tile.remove_flux(&mut rate, t.prediction);
            rate.iter_mut().for_each(|r| *r *= t.scale);
            rate
        });
        let mut stacked = parts.collect::<Vec<_>>().concat();
        self.shifts.remove_from(&mut stacked);
        stacked
    }

    /// Returns the gap of each tile.
    fn gaps(&self, residual: &[f64]) -> Vec<f64> {
        let energies = self.split(residual).map(energy).zip(&self.tiles);
        energies.map(|(e, t)| e / weight(t.tile)).collect()
    }

    /// Returns the parts of `stacked` that belong to each tile.
    fn split<'b>(&'b self, stacked: &'b [f64]) -> impl Iterator<Item = &'b [f64]> {
        let mut rest = stacked;
        self.tiles.iter().map(move |t| {
            let (own, others) = rest.split_at(t.prediction.len());
            rest = others;
            own
        })
    }
}

/// Returns the sum of squares of `values`.
fn energy(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum()
}
