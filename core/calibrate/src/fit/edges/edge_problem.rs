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
