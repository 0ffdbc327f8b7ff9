//! The descent of a pixel fit: Levenberg-Marquardt over all tiles at once, robust against bad ones.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::layout::Layout;
use super::metric::Metric;
use super::tile::{Buffers, Comparison, FitTile, Own, TileSystem};

/// Least variance of the symmetric blur that is fitted, px².
const LEAST_BLUR_PX2: f64 = 0.0;

/// Where a fit stands.
#[derive(Debug, Clone)]
pub(super) struct State {
    /// The lens's free numbers, in the layout's order.
    pub(super) theta: Vec<f64>,
    /// Every tile's own.
    pub(super) own: Vec<Own>,
}

/// How long to go on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patience {
    /// Steps at most.
    pub(super) steps: usize,
    /// Relative fall of the cost below which to stop.
    pub(super) fall: f64,
}

/// A fit at its end.
pub(super) struct Settled {
    pub(super) state: State,
    pub(super) systems: Vec<TileSystem>,
    pub(super) weights: Vec<f64>,
    pub(super) converged: bool,
}

impl Settled {
    /// Mean logarithm of the tiles' misfits.
    pub(super) fn typical(&self) -> f64 {
        let logs = self.systems.iter().map(|s| s.misfit.max(1e-12).ln());
        logs.sum::<f64>() / self.systems.len().max(1) as f64
    }
}

/// How tiles share in the cost: the logarithm of the misfit, as a mean of decibels has it, above a
/// scale below which it is linear; a misfit of many times the usual counts little.
#[derive(Debug, Clone, Copy)]
pub(super) struct Robust {
    scale: f64,
}

impl Robust {
    /// For tiles with these misfits.
    fn of(systems: &[TileSystem], comparison: Comparison, noisy: bool) -> Self {
        let mut all: Vec<f64> = systems.iter().map(|s| s.misfit).collect();
        all.sort_by(f64::total_cmp);
        let median = all[all.len() / 2];
        let scale = if comparison.metric == Metric::Pixels && noisy {
            // Misfits are about one where the noise is all: tiles up to a few times that count whole.
            10.0 * median.max(1.0)
        } else {
            comparison.tolerance * median.max(1e-12)
        };
        Self { scale }
    }

    fn cost(&self, system: &TileSystem) -> f64 {
        (system.misfit / self.scale).ln_1p() * self.scale * system.freedom
    }

    fn weight(&self, system: &TileSystem) -> f64 {
        1.0 / (1.0 + system.misfit / self.scale)
    }
}

/// A problem to descend in.
pub(super) struct Problem<'a> {
    pub(super) layout: &'a Layout,
    pub(super) tiles: &'a [&'a FitTile],
    pub(super) comparison: Comparison,
}

impl Problem<'_> {
    fn systems(&self, state: &State) -> Vec<TileSystem> {
        self.tiles
            .par_iter()
            .zip(&state.own)
            .map_init(Buffers::default, |buffers, (tile, own)| {
                tile.system(self.layout, &state.theta, own, self.comparison, buffers)
            })
            .collect()
    }

    /// The sum of all tiles' systems.
    pub(super) fn total(
        &self,
        systems: &[TileSystem],
        weights: &[f64],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.layout.slots.len();
        let mut normal = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        for (system, weight) in systems.iter().zip(weights) {
            for (a, &row) in system.slots.iter().enumerate() {
                right[row] += weight * system.right[a];
                for (b, &column) in system.slots.iter().enumerate() {
                    normal[(row, column)] += weight * system.normal[(a, b)];
                }
            }
        }
        (normal, right)
    }

    fn moved(&self, state: &State, systems: &[TileSystem], delta: &DVector<f64>) -> State {
        let mut theta: Vec<f64> = state
            .theta
            .iter()
            .zip(delta.iter())
            .map(|(t, d)| t + d)
            .collect();
        self.layout.keep_within(&mut theta, LEAST_BLUR_PX2);
        // What the bounds left of the step.
        let kept = DVector::from_iterator(
            theta.len(),
            theta.iter().zip(&state.theta).map(|(new, old)| new - old),
        );
        let own = state
            .own
            .iter()
            .zip(systems)
            .zip(self.tiles)
            .map(|((own, system), tile)| {
                let [light, x, y] = system.own_step(&kept);
                let near = |step: f64| step.clamp(-1.0, 1.0);
                let least = 0.2 * own.light.abs();
                let size = tile.size;
                Own {
                    light: (own.light + light).clamp(least, 5.0 * own.light.abs()),
                    centroid: [
                        (own.centroid[0] + near(x)).clamp(0.0, size.0 as f64),
                        (own.centroid[1] + near(y)).clamp(0.0, size.1 as f64),
                    ],
                }
            })
            .collect();
        State { theta, own }
    }

    /// Descends from `state`.
    pub(super) fn descend(&self, state: State, patience: Patience) -> Settled {
        let noisy = self.tiles.iter().any(|t| t.sigma > 0.0);
        let mut state = state;
        let mut systems = self.systems(&state);
        let mut damping = 1e-3;
        let mut converged = false;
        let mut robust = Robust::of(&systems, self.comparison, noisy);
        for _ in 0..patience.steps {
            robust = Robust::of(&systems, self.comparison, noisy);
            let weights: Vec<f64> = systems.iter().map(|s| robust.weight(s)).collect();
            let cost: f64 = systems.iter().map(|s| robust.cost(s)).sum();
            let (normal, right) = self.total(&systems, &weights);
            let free = self.free(&state, &right);
            let mut better = None;
            for _ in 0..6 {
                let delta = solve(&normal, &right, &free, damping);
                let trial = self.moved(&state, &systems, &delta);
                let there = self.systems(&trial);
                let new: f64 = there.iter().map(|s| robust.cost(s)).sum();
                if new < cost {
                    damping = (damping * 0.2).max(1e-9);
                    better = Some((trial, there, new));
                    break;
                }
                damping = (damping * 8.0).min(1e6);
                if (new - cost).abs() < 1e-7 * cost {
                    break;
                }
            }
            let Some((trial, there, new)) = better else {
                converged = true;
                break;
            };
            (state, systems) = (trial, there);
            if cost - new < patience.fall * cost {
                converged = true;
                break;
            }
        }
        let weights = systems.iter().map(|s| robust.weight(s)).collect();
        Settled {
            state,
            systems,
            weights,
            converged,
        }
    }

    /// Which numbers may move: not those that are held, nor those that stand at a bound and would go beyond it.
    fn free(&self, state: &State, right: &DVector<f64>) -> Vec<bool> {
        (0..right.len())
            .map(|k| {
                if self.layout.holds(k) {
                    return false;
                }
                let mut pushed = state.theta.clone();
                pushed[k] += 1e-6 * right[k].signum();
                let wanted = pushed[k];
                self.layout.keep_within(&mut pushed, LEAST_BLUR_PX2);
                pushed[k] == wanted
            })
            .collect()
    }
}

/// Solves the damped system for the numbers that are free; the others get zero.
fn solve(normal: &DMatrix<f64>, right: &DVector<f64>, free: &[bool], damping: f64) -> DVector<f64> {
    let chosen: Vec<usize> = (0..right.len())
        .filter(|&k| free[k] && normal[(k, k)] > 0.0)
        .collect();
    let root: Vec<f64> = chosen.iter().map(|&k| normal[(k, k)].sqrt()).collect();
    let scaled = DMatrix::from_fn(chosen.len(), chosen.len(), |a, b| {
        let value = normal[(chosen[a], chosen[b])] / (root[a] * root[b]);
        if a == b { value + damping } else { value }
    });
    let wanted = DVector::from_fn(chosen.len(), |a, _| right[chosen[a]] / root[a]);
    let mut delta = DVector::zeros(right.len());
    if let Some(factors) = scaled.cholesky() {
        let step = factors.solve(&wanted);
        for (a, &k) in chosen.iter().enumerate() {
            delta[k] = step[a] / root[a];
        }
    }
    delta
}
