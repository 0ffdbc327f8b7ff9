//! The least-squares problem of the optical axis: residuals as a function of the axis alone (variable projection).

use nalgebra::{DMatrix, DVector, Vector2};

use crate::least_squares::{
    Damping, LeastSquares, Minimum, NormalEquations, Stop, Trial, minimise,
};
use seidel_optics::field::ImagePoint;

/// Residuals of an axis, for a search by central differences.
pub(super) struct AxisProblem<R> {
    /// Residuals at an axis in the frame, px; `None` where the axis leaves the other unknowns undetermined.
    pub(super) residuals: R,
    /// Sum of the squares of residuals.
    pub(super) cost: fn(&DVector<f64>) -> f64,
    /// Step of the central differences, px.
    pub(super) difference_px: f64,
}

/// A trial axis.
pub(super) struct TrialAxis {
    /// Position in the frame, px.
    pub(super) axis: Vector2<f64>,
    /// Residuals there.
    pub(super) residuals: Option<DVector<f64>>,
}

impl<R: Fn(Vector2<f64>) -> Option<DVector<f64>>> AxisProblem<R> {
    /// Minimises the cost from `start`.
    pub(super) fn minimise(
        &self,
        start: ImagePoint,
        damping: Damping,
        stop: Stop,
    ) -> Minimum<TrialAxis> {
        let first = self.at(Vector2::new(start.x_px, start.y_px));
        minimise(self, first, damping, stop)
    }

    fn at(&self, axis: Vector2<f64>) -> TrialAxis {
        TrialAxis {
            axis,
            residuals: (self.residuals)(axis),
        }
    }

    fn cost(&self, point: &TrialAxis) -> f64 {
        (point.residuals.as_ref()).map_or(f64::INFINITY, self.cost)
    }

    /// Returns the derivatives of the residuals along `direction`.
    fn derivatives(&self, axis: Vector2<f64>, direction: Vector2<f64>) -> Option<DVector<f64>> {
        let offset = direction * self.difference_px;
        let difference = (self.residuals)(axis + offset)? - (self.residuals)(axis - offset)?;
        Some(difference / (2.0 * self.difference_px))
    }
}

impl<R: Fn(Vector2<f64>) -> Option<DVector<f64>>> LeastSquares for AxisProblem<R> {
    type Point = TrialAxis;

    /// Returns equations of zeros, which have no solution, where a derivative is undetermined.
    fn linearise(&self, point: &TrialAxis) -> NormalEquations {
        let along = |direction| self.derivatives(point.axis, direction);
        let (matrix, right) = match (along(Vector2::x()), along(Vector2::y()), &point.residuals) {
            (Some(x), Some(y), Some(residuals)) => {
                let jacobian = DMatrix::from_columns(&[x, y]);
                (jacobian.tr_mul(&jacobian), -jacobian.tr_mul(residuals))
            }
            _ => (DMatrix::zeros(2, 2), DVector::zeros(2)),
        };
        NormalEquations::new(matrix, right, self.cost(point))
    }

    fn trial(&self, point: &TrialAxis, equations: &NormalEquations) -> Option<Trial<TrialAxis>> {
        let step = equations.damped_step(|_| true)?;
        let moved = self.at(point.axis + Vector2::new(step[0], step[1]));
        let cost = self.cost(&moved);
        Some(Trial::new(moved, cost, &step))
    }
}
