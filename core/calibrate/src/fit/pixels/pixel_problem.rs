//! The least-squares problem of a pixel fit: all tiles at once, with a robust loss per tile.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::metric::Metric;
use super::parameters::ParameterLayout;
use super::tile_equations::{Buffers, FitTile, MisfitSettings, TileEquations, TileParameters};
use crate::least_squares::{Damping, LeastSquares, Minimum, NormalEquations, Stop, minimise};

/// Lower bound of the symmetric blur's variance, px².
const MIN_BLUR_PX2: f64 = 0.0;
/// Distance to a bound from which on a parameter counts as at the bound.
const BOUND_MARGIN: f64 = 1e-6;
/// Largest change of a tile's centroid in one step, px, and range of the factor of its flux. Larger steps are
/// outside the range of the linearisation.
const MAX_CENTROID_STEP_PX: f64 = 1.0;
const MIN_FLUX_FACTOR: f64 = 0.2;
const MAX_FLUX_FACTOR: f64 = 5.0;
/// Multiple of the median misfit up to which tiles of known noise keep nearly full weight. Where noise
/// dominates, misfits are about one.
const NOISE_TOLERANCE: f64 = 10.0;
const DAMPING: Damping = Damping {
    increase: 8.0,
    least: 1e-9,
    max_tries: 6,
    negligible_change: 1e-7,
};

/// Cauchy (Lorentzian) loss of a tile's misfit m: scale ln(1 + m / scale). It is linear in m below the scale
/// and logarithmic above, so outlying tiles have little influence.
#[derive(Debug, Clone, Copy)]
struct RobustLoss {
    scale: f64,
}

impl RobustLoss {
    /// Creates the loss that suits the median misfit of `equations`, all those of `tiles`.
    fn new(tiles: &[&FitTile], settings: MisfitSettings, equations: &[TileEquations]) -> Self {
        let mut misfits: Vec<f64> = equations.iter().map(|e| e.misfit).collect();
        misfits.sort_by(f64::total_cmp);
        let median = misfits[misfits.len() / 2];
        let noise_known = tiles.iter().any(|t| t.sigma > 0.0);
        let scale = if settings.metric == Metric::Pixels && noise_known {
            NOISE_TOLERANCE * median.max(1.0)
        } else {
            settings.tolerance * median.max(1e-12)
        };
        Self { scale }
    }

    fn cost(&self, equations: &TileEquations) -> f64 {
        (equations.misfit / self.scale).ln_1p() * self.scale * equations.freedom
    }

    fn weight(&self, equations: &TileEquations) -> f64 {
        1.0 / (1.0 + equations.misfit / self.scale)
    }
}

/// Parameters of the lens and of every tile, with the normal equations of every tile there.
pub(super) struct PixelPoint {
    /// Lens parameters, in the layout's order.
    pub(super) theta: Vec<f64>,
    /// Flux and centroid of every tile.
    own: Vec<TileParameters>,
    pub(super) equations: Vec<TileEquations>,
}

impl PixelPoint {
    /// Returns the mean logarithm of the tiles' misfits.
    pub(super) fn mean_log_misfit(&self) -> f64 {
        let logs = self.equations.iter().map(|e| e.misfit.max(1e-12).ln());
        logs.sum::<f64>() / self.equations.len().max(1) as f64
    }
}

/// Model, tiles and comparison of a fit.
pub(super) struct PixelProblem<'a> {
    layout: &'a ParameterLayout,
    tiles: &'a [&'a FitTile],
    settings: MisfitSettings,
    /// Loss of the current iteration.
    loss: RobustLoss,
    /// Units of the parameters in the current iteration, in which the normal matrix has a unit diagonal
    /// (Marquardt 1963).
    units: Vec<f64>,
}

impl<'a> PixelProblem<'a> {
    /// Creates the problem, and evaluates it at the lens parameters `theta` and the tile parameters `own`.
    pub(super) fn new(
        layout: &'a ParameterLayout,
        tiles: &'a [&'a FitTile],
        settings: MisfitSettings,
        theta: &[f64],
        own: Vec<TileParameters>,
    ) -> (Self, PixelPoint) {
        let start = evaluate(layout, tiles, settings, theta.to_vec(), own);
        let problem = Self {
            layout,
            tiles,
            settings,
            loss: RobustLoss::new(tiles, settings, &start.equations),
            units: vec![1.0; theta.len()],
        };
        (problem, start)
    }

    /// Minimises the cost from `start`.
    pub(super) fn minimise(mut self, start: PixelPoint, stop: Stop) -> Minimum<PixelPoint> {
        minimise(&mut self, start, DAMPING, stop)
    }

    /// Returns the weights of the tiles under the robust loss.
    pub(super) fn weights(&self, point: &PixelPoint) -> Vec<f64> {
        point
            .equations
            .iter()
            .map(|e| self.loss.weight(e))
            .collect()
    }

    /// Returns the weighted normal matrix of all tiles and its right-hand side.
    pub(super) fn total(&self, point: &PixelPoint) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.layout.parameters.len();
        let mut normal = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        for (equations, weight) in point.equations.iter().zip(self.weights(point)) {
            for (a, &row) in equations.parameters.iter().enumerate() {
                right[row] += weight * equations.right[a];
                for (b, &column) in equations.parameters.iter().enumerate() {
                    normal[(row, column)] += weight * equations.normal[(a, b)];
                }
            }
        }
        (normal, right)
    }

    /// Returns whether parameter `k` may move in the direction of `slope`: it is not fixed, and not at the
    /// bound that lies there.
    fn is_free(&self, theta: &[f64], k: usize, slope: f64) -> bool {
        if self.layout.is_fixed(k) {
            return false;
        }
        let mut pushed = theta.to_vec();
        pushed[k] += BOUND_MARGIN * slope.signum();
        let wanted = pushed[k];
        self.layout.clamp_to_bounds(&mut pushed, MIN_BLUR_PX2);
        pushed[k] == wanted
    }
}

impl LeastSquares for PixelProblem<'_> {
    type Point = PixelPoint;

    fn linearise(&mut self, point: &PixelPoint) -> NormalEquations {
        self.loss = RobustLoss::new(self.tiles, self.settings, &point.equations);
        let (mut normal, mut right) = self.total(point);
        let count = right.len();
        let unit = |square: f64| if square > 0.0 { square.sqrt() } else { 1.0 };
        self.units = normal.diagonal().iter().map(|&d| unit(d)).collect();
        for a in 0..count {
            right[a] /= self.units[a];
            for b in 0..count {
                normal[(a, b)] /= self.units[a] * self.units[b];
            }
        }
        NormalEquations {
            damping: DVector::from_element(count, 1.0),
            ..NormalEquations::new(normal, right, self.cost(point))
        }
    }

    fn cost(&self, point: &PixelPoint) -> f64 {
        point.equations.iter().map(|e| self.loss.cost(e)).sum()
    }

    fn moved(&self, point: &PixelPoint, step: &DVector<f64>) -> PixelPoint {
        let steps = step.iter().zip(&self.units).map(|(s, unit)| s / unit);
        let mut theta: Vec<f64> = point.theta.iter().zip(steps).map(|(t, s)| t + s).collect();
        self.layout.clamp_to_bounds(&mut theta, MIN_BLUR_PX2);
        // The part of the step inside the bounds.
        let kept = DVector::from_iterator(
            theta.len(),
            theta.iter().zip(&point.theta).map(|(new, old)| new - old),
        );
        let tiles = point.own.iter().zip(&point.equations).zip(self.tiles);
        let own = tiles
            .map(|((own, equations), tile)| {
                let [flux, x, y] = equations.tile_step(&kept);
                let short = |step: f64| step.clamp(-MAX_CENTROID_STEP_PX, MAX_CENTROID_STEP_PX);
                let (least, most) = (MIN_FLUX_FACTOR, MAX_FLUX_FACTOR);
                let size = own.flux.abs();
                let (width, height) = tile.size;
                TileParameters {
                    flux: (own.flux + flux).clamp(least * size, most * size),
                    centroid: [
                        (own.centroid[0] + short(x)).clamp(0.0, width as f64),
                        (own.centroid[1] + short(y)).clamp(0.0, height as f64),
                    ],
                }
            })
            .collect();
        evaluate(self.layout, self.tiles, self.settings, theta, own)
    }

    /// Fixed parameters, those at a bound that the gradient pushes against, and those without influence stay
    /// in place.
    fn damped_step(
        &self,
        point: &PixelPoint,
        equations: &NormalEquations,
        lambda: f64,
    ) -> Option<DVector<f64>> {
        let free: Vec<usize> = (0..equations.right.len())
            .filter(|&k| equations.matrix[(k, k)] > 0.0)
            .filter(|&k| self.is_free(&point.theta, k, equations.right[k]))
            .collect();
        equations.damped_step(lambda, &free)
    }
}

/// Returns the parameters with the normal equations of every tile.
fn evaluate(
    layout: &ParameterLayout,
    tiles: &[&FitTile],
    settings: MisfitSettings,
    theta: Vec<f64>,
    own: Vec<TileParameters>,
) -> PixelPoint {
    let equations = tiles
        .par_iter()
        .zip(&own)
        .map_init(Buffers::default, |buffers, (tile, own)| {
            tile.system(layout, &theta, own, settings, buffers)
        })
        .collect();
    PixelPoint {
        theta,
        own,
        equations,
    }
}
