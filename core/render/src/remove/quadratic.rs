//! The quadratic subproblem of an ADMM iteration, and the exact line search that lowers it.

use super::gradient::{Gradient, gradient_gram};
use super::problem::{BlurPair, Problem};
use super::vectors::{add_scaled, dot, weighted_gram};
use seidel_fourier::Complex;
use seidel_optics::error::Result;

/// Least determinant of the two-dimensional normal equations, as a share of the product of their diagonal: below, the
/// directions are parallel to rounding.
const MIN_DETERMINANT: f64 = 1e-9;

/// The quadratic Q(x) = f |W^(1/2) (A x - b)|² / 2 + r |D x - z + u|² / 2.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quadratic {
    /// f, the inverse variance of the residual.
    pub(super) data_weight: f64,
    /// r, the penalty of ADMM.
    pub(super) penalty: f64,
}

impl Quadratic {
    /// Returns the negative gradient of Q: f Aᵀ W (b - A x) + r Dᵀ (z - u - D x), the latter vector being `pull`.
    pub(super) fn descent(
        &self,
        problem: &Problem,
        estimate: &BlurPair,
        pull: &Gradient,
    ) -> Result<Vec<f32>> {
        let weighted = problem.weighted_residual(estimate, self.data_weight as f32);
        let mut descent = problem.operator.adjoint(weighted)?;
        add_scaled(
            &mut descent,
            &problem.operator.unstack(pull.adjoint()),
            self.penalty as f32,
        );
        Ok(descent)
    }

    /// Returns `descent` preconditioned by the inverse of the Hessian f |h|² + r |D|² on local spectra.
    pub(super) fn precondition(&self, problem: &Problem, descent: &[f32]) -> Result<Vec<f32>> {
        let (data_weight, penalty) = (self.data_weight as f32, self.penalty as f32);
        (problem.operator).precondition(descent, |h, gradient_power| {
            let hessian = h.norm_sqr() * data_weight + penalty * gradient_power;
            Complex::new(hessian.recip(), 0.0)
        })
    }

    /// Returns the share of the curvature at a frequency that comes from the plate and not from the prior:
    /// f |h|² / (f |h|² + r |D|²).
    pub(super) fn data_share(&self, h: Complex<f32>, gradient_power: f32) -> f32 {
        let data = h.norm_sqr() * self.data_weight as f32;
        let total = data + self.penalty as f32 * gradient_power;
        if total > 0.0 { data / total } else { 1.0 }
    }

    /// Returns the step to the minimum of Q over the plane that `direction` and the `previous` step span, or along
    /// `direction` if there is no previous step or it is parallel.
    ///
    /// The step solves the normal equations in the coefficients of the two, with `descent` as the negative gradient of Q.
    pub(super) fn line_search(
        &self,
        problem: &Problem,
        descent: &[f32],
        mut direction: BlurPair,
        previous: Option<BlurPair>,
    ) -> BlurPair {
        let operator = problem.operator;
        let other = previous.as_ref().unwrap_or(&direction);
        let data = weighted_gram(&direction.blurred, &other.blurred, &problem.weights);
        let prior = {
            let [a, b] = [&direction.image, &other.image].map(|image| operator.stack(image));
            gradient_gram(operator.linked(&a), operator.linked(&b))
        };
        let curvature = |data: f64, prior: f64| self.data_weight * data + self.penalty * prior;
        let a = curvature(data.aa, prior.aa);
        let b = curvature(data.ab, prior.ab);
        let c = curvature(data.bb, prior.bb);
        let p = dot(descent, &direction.image);
        let alone = if a > 0.0 { p / a } else { 0.0 };
        let Some(previous) = previous else {
            direction.scale(alone);
            return direction;
        };
        let q = dot(descent, &previous.image);
        let determinant = a * c - b * b;
        if determinant > MIN_DETERMINANT * a * c {
            direction.scale((p * c - q * b) / determinant);
            direction.add_scaled(&previous, (q * a - p * b) / determinant);
        } else {
            direction.scale(alone);
        }
        direction
    }
}
