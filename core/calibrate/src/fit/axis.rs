//! Estimation of the optical axis from the field dependence of the moments.

use nalgebra::{DVector, Vector2};

use super::axis_problem::AxisProblem;
use super::plane::{PlaneFit, Weighting, fit_plane, projected_residuals};
use crate::least_squares::{Damping, Stop};
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
        residuals: |axis: Vector2<f64>| {
            let frame = (start.with_axis(ImagePoint::new(axis.x, axis.y))).ok()?;
            let of = |fit| projected_residuals(&frame, fit, weighting).ok();
            let each = fits.iter().map(of).collect::<Option<Vec<_>>>()?;
            Some(DVector::from_vec(each.concat()))
        },
        cost: |residuals| residuals.iter().map(|r| r * r).sum(),
        difference_px: DIFFERENCE_STEP_PX,
    };
    let found = problem.minimise(start.axis(), DAMPING, STOP);
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
