//! The least-squares problem of a fit to edges: all edges at once, with a robust loss per edge.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::profile_model::FitEdge;
use crate::fit::pixels::bounds::BoundedStep;
use crate::fit::pixels::lens_equations::LensEquations;
use crate::fit::pixels::parameters::ParameterLayout;
use crate::least_squares::{
    CauchyLoss, Damping, LeastSquares, Minimum, NormalEquations, Stop, Trial, minimise,
};
use seidel_optics::field::FieldPoint;
use seidel_optics::numeric::median;

/// Multiple of the median misfit, at least one, up to which edges keep nearly full weight.
const TOLERANCE: f64 = 6.0;
const DAMPING: Damping = Damping {
    increase: 8.0,
    least: 1e-9,
    max_tries: 6,
    negligible_change: 1e-7,
};

/// Model and edges of a fit.
pub(super) struct EdgeProblem<'a> {
    pub(super) layout: &'a ParameterLayout,
    pub(super) edges: &'a [&'a FitEdge],
}

/// Lens parameters, with the misfit of every edge.
pub(super) struct EdgePoint {
    pub(super) theta: Vec<f64>,
    pub(super) misfits: Vec<f64>,
    loss: CauchyLoss,
}

impl EdgeProblem<'_> {
    /// Minimises the loss from `theta`.
    pub(super) fn minimise(&self, theta: &[f64], stop: Stop) -> Minimum<EdgePoint> {
        minimise(self, self.at(theta.to_vec()), DAMPING, stop)
    }

    pub(super) fn at(&self, theta: Vec<f64>) -> EdgePoint {
        let misfits: Vec<f64> = (self.edges.par_iter())
            .map(|edge| {
                let pupil = (self.layout).pupil(&theta, edge.channel, edge.at, edge.vergence);
                let misfit = edge.misfit(&pupil);
                if misfit.is_finite() { misfit } else { f64::MAX }
            })
            .collect();
        EdgePoint {
            loss: CauchyLoss {
                scale: TOLERANCE * median(&mut misfits.clone()).max(1.0),
            },
            theta,
            misfits,
        }
    }

    fn cost(&self, point: &EdgePoint, loss: CauchyLoss) -> f64 {
        let pairs = self.edges.iter().zip(&point.misfits);
        pairs.map(|(edge, m)| loss.cost(*m, edge.freedom())).sum()
    }

    /// Returns the mean loss of a degree of freedom at `point`, under the scale of `other`.
    pub(super) fn mean_cost(&self, point: &EdgePoint, other: &EdgePoint) -> f64 {
        let freedom: f64 = self.edges.iter().map(|e| e.freedom()).sum();
        self.cost(point, other.loss) / freedom
    }

    /// Returns the covariance of the parameters by the jackknife over zones of the frame: how they move when one zone is left out,
    /// each by one step of Gauss-Newton from `point`. It holds the errors of a model that fits no zone exactly, which the noise
    /// does not show. `inverse` inverts a normal matrix.
    pub(super) fn jackknife(
        &self,
        point: &EdgePoint,
        inverse: &dyn Fn(&DMatrix<f64>) -> DMatrix<f64>,
    ) -> DMatrix<f64> {
        let count = point.theta.len();
        let (total, _) = self.total(point);
        let mut covariance = DMatrix::zeros(count, count);
        let mut zones = 0.0;
        for zone in 0..ZONES[0] * ZONES[1] {
            let mut edges = Vec::new();
            let mut own = EdgePoint {
                theta: point.theta.clone(),
                misfits: Vec::new(),
                loss: point.loss,
            };
            for (edge, misfit) in self.edges.iter().zip(&point.misfits) {
                if zone_of(edge.at) == zone {
                    edges.push(*edge);
                    own.misfits.push(*misfit);
                }
            }
            if edges.is_empty() {
                continue;
            }
            zones += 1.0;
            let of_zone = EdgeProblem {
                layout: self.layout,
                edges: &edges,
            };
            let (normal, right) = of_zone.total(&own);
            let moved = inverse(&(&total - normal)) * right;
            covariance += &moved * moved.transpose();
        }
        covariance * ((zones - 1.0) / f64::max(zones, 1.0))
    }

    /// Returns the weighted normal matrix and its right-hand side.
    pub(super) fn total(&self, point: &EdgePoint) -> (DMatrix<f64>, DVector<f64>) {
        let each: Vec<_> = (self.edges.par_iter())
            .map(|edge| edge.equations(self.layout, &point.theta).0)
            .collect();
        let weights = point
            .misfits
            .iter()
            .map(|misfit| point.loss.weight(*misfit));
        LensEquations::total(self.layout, each.iter().zip(weights))
    }
}

/// Columns and rows of the zones of the jackknife.
const ZONES: [usize; 2] = [5, 4];

/// Returns the index of the zone of a place; those beyond the unit square belong to its border.
fn zone_of(at: FieldPoint) -> usize {
    let index = |v: f64, most: usize| {
        let share = (v + 1.0) / 2.0;
        ((share * most as f64).max(0.0) as usize).min(most - 1)
    };
    // Frames are about two thirds as high as wide.
    index(1.5 * at.y, ZONES[1]) * ZONES[0] + index(at.x, ZONES[0])
}

impl LeastSquares for EdgeProblem<'_> {
    type Point = EdgePoint;

    fn linearise(&self, point: &EdgePoint) -> NormalEquations {
        let (normal, right) = self.total(point);
        NormalEquations::new(normal, right, self.cost(point, point.loss))
    }

    fn trial(&self, point: &EdgePoint, equations: &NormalEquations) -> Option<Trial<EdgePoint>> {
        let BoundedStep { theta, step } = self.layout.bounded_step(&point.theta, equations)?;
        let moved = self.at(theta);
        let cost = self.cost(&moved, point.loss);
        Some(Trial::new(moved, cost, &step))
    }
}
