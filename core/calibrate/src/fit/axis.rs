//! Estimation of the optical axis from the field dependence of the moments.

use nalgebra::{DMatrix, DVector, Vector2};

use super::plane::{PlaneFit, Weighting, fit_plane, projected_residuals};
use crate::least_squares::{Damping, LeastSquares, NormalEquations, Stop, minimise};
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
}

/// Result of [`find_axis`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisFit {
    /// Position in the frame, px.
    pub axis: ImagePoint,
    /// Standard errors along x and y, px.
    pub sigma_px: (f64, f64),
    /// Whether the last step was shorter than 0.01 px.
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
) -> Result<AxisFit> {
    // Outliers and weights are fixed at the initial axis, so that the cost function stays the same.
    let fits: Vec<PlaneFit> = groups
        .iter()
        .map(|group| fit_plane(start, group, weighting))
        .collect::<Result<_>>()?;
    let mut problem = AxisProblem {
        frame: start,
        fits: &fits,
        weighting,
    };
    let first = problem.at(Vector2::new(start.axis().x_px, start.axis().y_px));
    let found = minimise(&mut problem, first, DAMPING, STOP);
    // Two coordinates, and ten coefficients per group.
    let unknowns = 2 + 10 * fits.len();
    let residuals = found.point.residuals.as_ref().map_or(0, Vec::len);
    let freedom = residuals.saturating_sub(unknowns).max(1) as f64;
    let Some(inverse) = found.last_equations.matrix.try_inverse() else {
        return Err(Error::new(
            "optical axis",
            "is not determined by these observations",
            "give observations off the axis, or state the axis",
        ));
    };
    let sigma_px = |k: usize| (inverse[(k, k)] * (found.cost / freedom)).sqrt();
    Ok(AxisFit {
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
    residuals: Option<Vec<f64>>,
}

impl AxisProblem<'_> {
    fn at(&self, axis: Vector2<f64>) -> TrialAxis {
        TrialAxis {
            axis,
            residuals: self.residuals(axis).ok(),
        }
    }

    fn residuals(&self, axis: Vector2<f64>) -> Result<Vec<f64>> {
        let frame = self.frame.with_axis(ImagePoint::new(axis.x, axis.y))?;
        let mut all = Vec::new();
        for fit in self.fits {
            all.extend(projected_residuals(&frame, fit, self.weighting)?);
        }
        Ok(all)
    }

    /// Returns the derivatives of the residuals by coordinate `k` of the axis, by central differences.
    fn derivatives(&self, axis: Vector2<f64>, k: usize) -> Option<DVector<f64>> {
        let mut offset = Vector2::zeros();
        offset[k] = DIFFERENCE_STEP_PX;
        let low = DVector::from_vec(self.residuals(axis - offset).ok()?);
        let high = DVector::from_vec(self.residuals(axis + offset).ok()?);
        Some((high - low) / (2.0 * DIFFERENCE_STEP_PX))
    }
}

impl LeastSquares for AxisProblem<'_> {
    type Point = TrialAxis;

    /// Returns equations of zeros, which have no solution, where a derivative is undetermined.
    fn linearise(&mut self, point: &TrialAxis) -> NormalEquations {
        let columns: Option<Vec<_>> = (0..2).map(|k| self.derivatives(point.axis, k)).collect();
        let (matrix, right) = match (columns, &point.residuals) {
            (Some(columns), Some(residuals)) => {
                let jacobian = DMatrix::from_columns(&columns);
                let residuals = DVector::from_column_slice(residuals);
                (jacobian.tr_mul(&jacobian), -jacobian.tr_mul(&residuals))
            }
            _ => (DMatrix::zeros(2, 2), DVector::zeros(2)),
        };
        NormalEquations::new(matrix, right, self.cost(point))
    }

    fn cost(&self, point: &TrialAxis) -> f64 {
        let residuals = point.residuals.as_ref();
        residuals.map_or(f64::INFINITY, |r| r.iter().map(|r| r * r).sum())
    }

    fn moved(&self, point: &TrialAxis, step: &DVector<f64>) -> TrialAxis {
        self.at(point.axis + Vector2::new(step[0], step[1]))
    }
}
