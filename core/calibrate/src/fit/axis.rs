//! Estimation of the optical axis from the field dependence of the moments.

use nalgebra::{Matrix2, Vector2};

use super::plane::{PlaneFit, Weighting, fit_plane, projected_residuals};
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
    /// Iterations of Levenberg-Marquardt.
    pub steps: usize,
    /// Whether the last step was shorter than 0.01 px.
    pub converged: bool,
}

const MAX_STEPS: usize = 40;
/// Step of the central differences, px. Residuals are smooth over whole pixels.
const DIFFERENCE_STEP_PX: f64 = 2.0;
const CONVERGED_PX: f64 = 0.01;

/// Estimates the axis by Levenberg-Marquardt with variable projection.
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
    let kept: Vec<PlaneFit> = groups
        .iter()
        .map(|group| fit_plane(start, group, weighting))
        .collect::<Result<_>>()?;
    let residuals = |axis: Vector2<f64>| -> Result<Vec<f64>> {
        let frame = start.with_axis(ImagePoint::new(axis.x, axis.y))?;
        let mut all = Vec::new();
        for fit in &kept {
            all.extend(projected_residuals(&frame, fit, weighting)?);
        }
        Ok(all)
    };
    let mut axis = Vector2::new(start.axis().x_px, start.axis().y_px);
    let mut here = residuals(axis)?;
    let mut cost: f64 = here.iter().map(|r| r * r).sum();
    let mut damping = 1e-3;
    let mut steps = 0;
    let mut converged = false;
    let mut normal = Matrix2::zeros();
    while steps < MAX_STEPS && !converged {
        steps += 1;
        let mut slopes = [Vec::new(), Vec::new()];
        for (k, slope) in slopes.iter_mut().enumerate() {
            let mut probe = Vector2::zeros();
            probe[k] = DIFFERENCE_STEP_PX;
            let (low, high) = (residuals(axis - probe)?, residuals(axis + probe)?);
            *slope = high
                .iter()
                .zip(&low)
                .map(|(h, l)| (h - l) / (2.0 * DIFFERENCE_STEP_PX))
                .collect();
        }
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        normal = Matrix2::from_fn(|r, c| dot(&slopes[r], &slopes[c]));
        let gradient = Vector2::from_fn(|r, _| dot(&slopes[r], &here));
        loop {
            let damped = normal + Matrix2::from_diagonal(&(normal.diagonal() * damping));
            let Some(inverse) = damped.try_inverse() else {
                return Err(Error::new(
                    "optical axis",
                    "is not determined by these observations",
                    "give observations off the axis, or state the axis",
                ));
            };
            let step = -(inverse * gradient);
            let trial = axis + step;
            let there = residuals(trial);
            let trial_cost = there
                .as_ref()
                .map_or(f64::INFINITY, |r| r.iter().map(|r| r * r).sum());
            if trial_cost <= cost {
                converged = step.norm() < CONVERGED_PX;
                axis = trial;
                cost = trial_cost;
                here = there?;
                damping = (damping * 0.2).max(1e-9);
                break;
            }
            damping *= 8.0;
            if damping > 1e9 {
                converged = step.norm() < CONVERGED_PX;
                steps = MAX_STEPS;
                break;
            }
        }
    }
    // Two coordinates, and ten coefficients per group.
    let unknowns = 2 + 10 * kept.len();
    let freedom = here.len().saturating_sub(unknowns).max(1) as f64;
    let covariance = normal
        .try_inverse()
        .unwrap_or_else(Matrix2::zeros)
        .scale(cost / freedom);
    Ok(AxisFit {
        axis: ImagePoint::new(axis.x, axis.y),
        sigma_px: (covariance[(0, 0)].sqrt(), covariance[(1, 1)].sqrt()),
        steps,
        converged,
    })
}
