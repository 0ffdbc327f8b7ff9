//! Parameters at their bounds.

use nalgebra::DVector;

use super::parameters::ParameterLayout;
use crate::least_squares::NormalEquations;

/// Distance to a bound from which on a parameter counts as at the bound.
const BOUND_MARGIN: f64 = 1e-6;
/// Lower bound of the symmetric blur's variance, px².
const MIN_BLUR_PX2: f64 = 0.0;

/// A step of the lens parameters.
pub(in crate::fit) struct BoundedStep {
    /// The parameters after the step, within their bounds.
    pub(in crate::fit) theta: Vec<f64>,
    /// The step as the equations give it.
    pub(in crate::fit) step: DVector<f64>,
}

impl ParameterLayout {
    /// Returns the step from `theta` that solves the damped `equations`. Fixed parameters, those at a bound that the gradient
    /// pushes against, and those without influence stay in place.
    pub(in crate::fit) fn bounded_step(
        &self,
        theta: &[f64],
        equations: &NormalEquations,
    ) -> Option<BoundedStep> {
        let step = equations.scaled_step(|k| {
            equations.matrix[(k, k)] > 0.0 && self.is_free(theta, k, equations.right[k])
        })?;
        let moved = theta.iter().zip(&step).map(|(t, s)| t + s);
        let mut theta: Vec<f64> = moved.collect();
        self.clamp_to_bounds(&mut theta, MIN_BLUR_PX2);
        Some(BoundedStep { theta, step })
    }

    /// Returns whether parameter `k` of `theta` is free and lies at one of its bounds.
    pub(in crate::fit) fn is_at_bound(&self, theta: &[f64], k: usize) -> bool {
        let slopes = [1.0, -1.0];
        !self.is_fixed(k) && slopes.iter().any(|slope| !self.is_free(theta, k, *slope))
    }

    /// Returns whether parameter `k` of `theta` may move in the direction of `slope`: it is not fixed, and not at the bound that
    /// lies there.
    fn is_free(&self, theta: &[f64], k: usize, slope: f64) -> bool {
        if self.is_fixed(k) {
            return false;
        }
        let mut pushed = theta.to_vec();
        pushed[k] += BOUND_MARGIN * slope.signum();
        let wanted = pushed[k];
        self.clamp_to_bounds(&mut pushed, MIN_BLUR_PX2);
        pushed[k] == wanted
    }
}
