//! Estimation of the optical axis from the field dependence of the moments.

use nalgebra::{DMatrix, DVector, Vector2};

use super::plane::{PlaneFit, Weighting, fit_plane, projected_residuals};
use crate::least_squares::{Damping, LeastSquares, NormalEquations, Stop, Trial, minimise};
use crate::measure::MeasuredTile;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::{Frame, ImagePoint};

/// Estimated position of the optical axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisEstimate {
    /// Position in the frame, px.
    pub axis: ImagePoint,
    /// Standard errors along x and y, px.
    pub sigma_px: (f64, f64),
    /// Whether the minimisation that estimated it converged.
    pub converged: bool,
}

/// Step of the central differences, px. Residuals are smooth over whole pixels.
const DIFFERENCE_STEP_PX: f64 = 2.0;
const DAMPING: Damping = Damping {
    increase: 8.0,
    least: 1e-9,
    max_tries: usize::MAX,
    negligible_change: 0.0,
};
/// Convergence at a step below 0.01 px.
const STOP: Stop = Stop {
    max_iterations: 40,
    min_decrease: f64::INFINITY,
    min_step: 0.01,
};

/// Estimates the axis by Levenberg-Marquardt with variable projection (Golub and Pereyra 1973).
///
/// Each trial position refits S1..S10 of every group by linear least squares. `groups` are the tiles of each
/// channel and distance. The residuals are those of moments; positions of PSFs do not enter.
///
/// # Errors
/// As [`fit_plane`]; or moments that do not depend on the axis.
pub fn find_axis(
    start: &Frame,
    groups: &[&[&MeasuredTile]],
    weighting: Weighting,
) -> Result<AxisEstimate> {
    // Outliers and weights are fixed at the initial axis, so that the cost function stays the same.
    let fits: Vec<PlaneFit> = groups
        .iter()
        .map(|group| fit_plane(start, group, weighting))
        .collect::<Result<_>>()?;
    let problem = AxisProblem {
        frame: start,
        fits: &fits,
        weighting,
    };
    let first = problem.at(Vector2::new(start.axis().x_px, start.axis().y_px));
    let found = minimise(&problem, first, DAMPING, STOP);
    let Some(inverse) = found.last_equations.matrix.try_inverse() else {
        return Err(Error::new(
            "optical axis",
            "is not determined by these observations",
            "give observations off the axis, or state the axis",
        ));
    };
    // Two coordinates, and ten coefficients per group.
    let unknowns = 2 + 10 * fits.len();
    let residuals = found.point.residuals.map_or(0, |r| r.len());
    let freedom = residuals.saturating_sub(unknowns).max(1) as f64;
    let sigma_px = |k: usize| (inverse[(k, k)] * (found.cost / freedom)).sqrt();
    Ok(AxisEstimate {
        axis: ImagePoint::new(found.point.axis.x, found.point.axis.y),
        sigma_px: (sigma_px(0), sigma_px(1)),
        converged: found.converged,
    })
}

/// The moments of all groups as functions of the axis alone.
struct AxisProblem<'a> {
    frame: &'a Frame,
    fits: &'a [PlaneFit<'a>],
    weighting: Weighting,
}

/// A trial axis.
struct TrialAxis {
    /// Position in the frame, px.
    axis: Vector2<f64>,
    /// Residuals of all moments; `None` where the axis leaves S1..S10 undetermined.
    residuals: Option<DVector<f64>>,
}

impl TrialAxis {
    fn cost(&self) -> f64 {
        let residuals = self.residuals.as_ref();
        residuals.map_or(f64::INFINITY, |r| r.iter().map(|r| r * r).sum())
    }
}

impl AxisProblem<'_> {
    fn at(&self, axis: Vector2<f64>) -> TrialAxis {
        let frame = self.frame.with_axis(ImagePoint::new(axis.x, axis.y));
        let residuals = frame.and_then(|frame| {
            let of = |fit| projected_residuals(&frame, fit, self.weighting);
            Ok(self
                .fits
                .iter()
                .map(of)
                .collect::<Result<Vec<_>>>()?
                .concat())
        });
        TrialAxis {
            axis,
            residuals: residuals.ok().map(DVector::from_vec),
        }
    }

    /// Returns the derivatives of the residuals along `direction`, by central differences.
    fn derivatives(&self, axis: Vector2<f64>, direction: Vector2<f64>) -> Option<DVector<f64>> {
        let offset = direction * DIFFERENCE_STEP_PX;
        let difference = self.at(axis + offset).residuals? - self.at(axis - offset).residuals?;
        Some(difference / (2.0 * DIFFERENCE_STEP_PX))
    }
}

impl LeastSquares for AxisProblem<'_> {
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
        NormalEquations::new(matrix, right, point.cost())
    }

    fn trial(&self, point: &TrialAxis, equations: &NormalEquations) -> Option<Trial<TrialAxis>> {
        let step = equations.damped_step(|_| true)?;
        let moved = self.at(point.axis + Vector2::new(step[0], step[1]));
        let cost = moved.cost();
        Some(Trial::new(moved, cost, &step))
    }
}
