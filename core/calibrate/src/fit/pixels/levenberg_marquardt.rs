//! Levenberg-Marquardt over all tiles at once, with a robust loss per tile.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::metric::Metric;
use super::parameters::ParameterLayout;
use super::tile_equations::{Buffers, FitTile, MisfitSettings, TileEquations, TileParameters};

/// Lower bound of the symmetric blur's variance, px².
const MIN_BLUR_PX2: f64 = 0.0;

/// Parameters of the lens and of every tile.
#[derive(Debug, Clone)]
pub(super) struct FitState {
    /// Lens parameters, in the layout's order.
    pub(super) theta: Vec<f64>,
    /// Flux and centroid of every tile.
    pub(super) own: Vec<TileParameters>,
}

/// Stop criteria of the minimisation.
#[derive(Debug, Clone, Copy)]
pub(super) struct StopCriteria {
    /// Maximum number of iterations.
    pub(super) max_steps: usize,
    /// Relative decrease of the cost below which the minimisation has converged.
    pub(super) min_decrease: f64,
}

/// Result of a minimisation.
pub(super) struct Minimum {
    pub(super) state: FitState,
    pub(super) systems: Vec<TileEquations>,
    pub(super) weights: Vec<f64>,
    pub(super) converged: bool,
}

impl Minimum {
    /// Returns the mean logarithm of the tiles' misfits.
    pub(super) fn mean_log_misfit(&self) -> f64 {
        let logs = self.systems.iter().map(|s| s.misfit.max(1e-12).ln());
        logs.sum::<f64>() / self.systems.len().max(1) as f64
    }
}

/// Cauchy (Lorentzian) loss of a tile's misfit m: scale ln(1 + m / scale). It is linear in m below the scale
/// and logarithmic above, so outlying tiles have little influence.
#[derive(Debug, Clone, Copy)]
pub(super) struct RobustLoss {
    scale: f64,
}

impl RobustLoss {
    /// Returns the loss scaled to the median of these misfits.
    fn of(systems: &[TileEquations], misfit_settings: MisfitSettings, noisy: bool) -> Self {
        let mut all: Vec<f64> = systems.iter().map(|s| s.misfit).collect();
        all.sort_by(f64::total_cmp);
        let median = all[all.len() / 2];
        let scale = if misfit_settings.metric == Metric::Pixels && noisy {
            // Where noise dominates misfits are about one; tiles up to ten times that keep nearly full
            // weight.
            10.0 * median.max(1.0)
        } else {
            misfit_settings.tolerance * median.max(1e-12)
        };
        Self { scale }
    }

    fn cost(&self, system: &TileEquations) -> f64 {
        (system.misfit / self.scale).ln_1p() * self.scale * system.freedom
    }

    fn weight(&self, system: &TileEquations) -> f64 {
        1.0 / (1.0 + system.misfit / self.scale)
    }
}

/// A minimisation problem: model, tiles and comparison.
pub(super) struct Problem<'a> {
    pub(super) layout: &'a ParameterLayout,
    pub(super) tiles: &'a [&'a FitTile],
    pub(super) misfit_settings: MisfitSettings,
}

impl Problem<'_> {
    fn systems(&self, state: &FitState) -> Vec<TileEquations> {
        self.tiles
            .par_iter()
            .zip(&state.own)
            .map_init(Buffers::default, |buffers, (tile, own)| {
                tile.system(
                    self.layout,
                    &state.theta,
                    own,
                    self.misfit_settings,
                    buffers,
                )
            })
            .collect()
    }

    /// Assembles the weighted normal equations of all tiles.
    pub(super) fn total(
        &self,
        systems: &[TileEquations],
        weights: &[f64],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.layout.parameters.len();
        let mut normal = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        for (system, weight) in systems.iter().zip(weights) {
            for (a, &row) in system.parameters.iter().enumerate() {
                right[row] += weight * system.right[a];
                for (b, &column) in system.parameters.iter().enumerate() {
                    normal[(row, column)] += weight * system.normal[(a, b)];
                }
            }
        }
        (normal, right)
    }

    fn moved(&self, state: &FitState, systems: &[TileEquations], delta: &DVector<f64>) -> FitState {
        let mut theta: Vec<f64> = state
            .theta
            .iter()
            .zip(delta.iter())
            .map(|(t, d)| t + d)
            .collect();
        self.layout.clamp_to_bounds(&mut theta, MIN_BLUR_PX2);
        // The part of the step inside the bounds.
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
                let [light, x, y] = system.tile_step(&kept);
                let near = |step: f64| step.clamp(-1.0, 1.0);
                let least = 0.2 * own.flux.abs();
                let size = tile.size;
                TileParameters {
                    flux: (own.flux + light).clamp(least, 5.0 * own.flux.abs()),
                    centroid: [
                        (own.centroid[0] + near(x)).clamp(0.0, size.0 as f64),
                        (own.centroid[1] + near(y)).clamp(0.0, size.1 as f64),
                    ],
                }
            })
            .collect();
        FitState { theta, own }
    }

    /// Minimises the cost from `state`.
    pub(super) fn descend(&self, state: FitState, stop: StopCriteria) -> Minimum {
        let noisy = self.tiles.iter().any(|t| t.sigma > 0.0);
        let mut state = state;
        let mut systems = self.systems(&state);
        let mut damping = 1e-3;
        let mut converged = false;
        let mut robust = RobustLoss::of(&systems, self.misfit_settings, noisy);
        for _ in 0..stop.max_steps {
            robust = RobustLoss::of(&systems, self.misfit_settings, noisy);
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
            if cost - new < stop.min_decrease * cost {
                converged = true;
                break;
            }
        }
        let weights = systems.iter().map(|s| robust.weight(s)).collect();
        Minimum {
            state,
            systems,
            weights,
            converged,
        }
    }

    /// Returns which parameters may move: those neither fixed nor pushed beyond a bound.
    fn free(&self, state: &FitState, right: &DVector<f64>) -> Vec<bool> {
        (0..right.len())
            .map(|k| {
                if self.layout.is_fixed(k) {
                    return false;
                }
                let mut pushed = state.theta.clone();
                pushed[k] += 1e-6 * right[k].signum();
                let wanted = pushed[k];
                self.layout.clamp_to_bounds(&mut pushed, MIN_BLUR_PX2);
                pushed[k] == wanted
            })
            .collect()
    }
}

/// Solves the damped normal equations for the free parameters; the others get a zero step.
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
