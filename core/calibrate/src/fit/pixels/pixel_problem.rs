//! The least-squares problem of a pixel fit: all tiles at once, with a robust loss per tile.

use std::sync::OnceLock;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::bounds::BoundedStep;
use super::lens_equations::LensEquations;
use super::metric::Metric;
use super::parameters::ParameterLayout;
use super::tile_equations::{Comparison, FitTile, MisfitSettings, TileEquations, TileParameters};
use crate::least_squares::{
    CauchyLoss, Damping, LeastSquares, Minimum, NormalEquations, Stop, Trial, minimise,
};
use seidel_optics::numeric::median;

/// Largest change of a tile's centroid in one step, px, and range of the factor of its flux. Larger steps are
/// outside the range of the linearisation.
const MAX_CENTROID_STEP_PX: f64 = 1.0;
const MIN_FLUX_FACTOR: f64 = 0.2;
const MAX_FLUX_FACTOR: f64 = 5.0;
/// Multiple of the median misfit up to which tiles of known noise keep nearly full weight. Where noise
/// dominates, misfits are about one; those of two lights in one tile are a few times as large.
const NOISE_TOLERANCE: f64 = 3.0;
const DAMPING: Damping = Damping {
    increase: 8.0,
    least: 1e-9,
    max_tries: 6,
    negligible_change: 1e-7,
};

/// Returns the loss that suits the median of `misfits`, those of all `tiles`.
fn robust_loss(tiles: &[&FitTile], settings: MisfitSettings, misfits: &[f64]) -> CauchyLoss {
    let median = median(&mut misfits.to_vec());
    let noise_known = tiles.iter().any(|t| t.sigma > 0.0);
    let scale = if settings.metric == Metric::Pixels && noise_known {
        NOISE_TOLERANCE * median.max(1.0)
    } else {
        settings.tolerance * median.max(1e-12)
    };
    CauchyLoss { scale }
}

/// Parameters of the lens and of every tile, with the misfits there.
pub(super) struct PixelPoint {
    /// Lens parameters, in the layout's order.
    pub(super) theta: Vec<f64>,
    /// Flux and centroid of every tile.
    own: Vec<TileParameters>,
    /// Misfit of every tile, and its degrees of freedom.
    misfits: Vec<f64>,
    freedoms: Vec<f64>,
    /// Normal equations of every tile, once they were asked for: they cost far more than the misfits.
    equations: OnceLock<Vec<TileEquations>>,
    /// Loss that suits the misfits at this point.
    loss: CauchyLoss,
}

impl PixelPoint {
    /// Returns the mean logarithm of the tiles' misfits.
    pub(super) fn mean_log_misfit(&self) -> f64 {
        let logs = self.misfits.iter().map(|m| m.max(1e-12).ln());
        logs.sum::<f64>() / self.misfits.len().max(1) as f64
    }

    /// Returns the weights of the tiles under the robust loss.
    pub(super) fn weights(&self) -> impl Iterator<Item = f64> {
        self.misfits.iter().map(|m| self.loss.weight(*m))
    }

    /// Returns the weight of a tile that differs from the lens by its noise alone.
    pub(super) fn weight_of_noise(&self) -> f64 {
        self.loss.weight(1.0)
    }

    /// Returns the cost here under `loss`.
    fn cost(&self, loss: CauchyLoss) -> f64 {
        let tiles = self.misfits.iter().zip(&self.freedoms);
        tiles.map(|(m, freedom)| loss.cost(*m, *freedom)).sum()
    }
}

/// Model, tiles and comparison of a fit.
pub(super) struct PixelProblem<'a> {
    pub(super) layout: &'a ParameterLayout,
    pub(super) tiles: &'a [&'a FitTile],
    pub(super) settings: MisfitSettings,
}

impl PixelProblem<'_> {
    /// Minimises the cost from `start`.
    pub(super) fn minimise(&self, start: PixelPoint, stop: Stop) -> Minimum<PixelPoint> {
        minimise(self, start, DAMPING, stop)
    }

    /// Evaluates the lens parameters `theta` with the tile parameters `own`.
    pub(super) fn at(&self, theta: Vec<f64>, own: Vec<TileParameters>) -> PixelPoint {
        let pairs = self.tiles.par_iter().zip(&own);
        let misfits: Vec<f64> = pairs
            .map_init(
                || Comparison::new(self.settings),
                |comparison, (tile, own)| {
                    let pupil = self
                        .layout
                        .pupil(&theta, tile.channel, tile.at, tile.vergence);
                    tile.misfit(&pupil, own, comparison)
                },
            )
            .collect();
        let freedoms = self.tiles.iter().map(|tile| tile.freedom(self.settings));
        PixelPoint {
            loss: robust_loss(self.tiles, self.settings, &misfits),
            freedoms: freedoms.collect(),
            theta,
            own,
            misfits,
            equations: OnceLock::new(),
        }
    }

    /// Returns the normal equations of every tile at `point`.
    pub(super) fn equations<'p>(&self, point: &'p PixelPoint) -> &'p [TileEquations] {
        point.equations.get_or_init(|| {
            let pairs = self.tiles.par_iter().zip(&point.own);
            pairs
                .map_init(
                    || Comparison::new(self.settings),
                    |comparison, (tile, own)| {
                        tile.system(self.layout, &point.theta, own, comparison)
                    },
                )
                .collect()
        })
    }

    /// Returns the weighted normal matrix of all tiles and its right-hand side.
    pub(super) fn total(&self, point: &PixelPoint) -> (DMatrix<f64>, DVector<f64>) {
        let equations = self.equations(point).iter().map(|tile| &tile.lens);
        LensEquations::total(self.layout, equations.zip(point.weights()))
    }
}

impl LeastSquares for PixelProblem<'_> {
    type Point = PixelPoint;

    fn linearise(&self, point: &PixelPoint) -> NormalEquations {
        let (normal, right) = self.total(point);
        NormalEquations::new(normal, right, point.cost(point.loss))
    }

    fn trial(&self, point: &PixelPoint, equations: &NormalEquations) -> Option<Trial<PixelPoint>> {
        let BoundedStep { theta, step } = self.layout.bounded_step(&point.theta, equations)?;
        // The part of the step inside the bounds.
        let kept = theta.iter().zip(&point.theta).map(|(new, old)| new - old);
        let kept = DVector::from_iterator(theta.len(), kept);
        let tiles = point.own.iter().zip(self.equations(point)).zip(self.tiles);
        let own = tiles
            .map(|((own, equations), tile)| {
                let [flux, x, y] = equations.tile_step(&kept);
                let short = |step: f64| step.clamp(-MAX_CENTROID_STEP_PX, MAX_CENTROID_STEP_PX);
                let size = own.flux.abs();
                let (width, height) = tile.size;
                TileParameters {
                    flux: (own.flux + flux).clamp(MIN_FLUX_FACTOR * size, MAX_FLUX_FACTOR * size),
                    centroid: [
                        (own.centroid[0] + short(x)).clamp(0.0, width as f64),
                        (own.centroid[1] + short(y)).clamp(0.0, height as f64),
                    ],
                }
            })
            .collect();
        let moved = self.at(theta, own);
        let cost = moved.cost(point.loss);
        Some(Trial::new(moved, cost, &step))
    }
}
