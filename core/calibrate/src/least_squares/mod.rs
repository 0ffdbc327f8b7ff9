//! Least squares: the Levenberg-Marquardt method for nonlinear problems, and a direct solver for linear ones.
//!
//! [`minimise`] serves every nonlinear fit of this package. At each point a [`LeastSquares`] problem gives
//! its normal equations J'J d = J'r, with the residuals r = observed - predicted and the Jacobian J of the
//! prediction. The step d solves the damped equations
//!
//! (J'J + lambda D² + R) d = J'r.
//!
//! D² is the diagonal of J'J (Marquardt 1963), or that of a scaling matrix (Moré 1978) which the problem
//! chooses. R is an optional ridge, which keeps parameters without influence in place. A step that lowers the
//! cost is taken, and lambda falls; after any other step lambda rises ([`Damping`]). Iterations end as
//! [`Stop`] says, or when no step lowers the cost.
//!
//! With a robust loss the problem weights its normal equations, and the cost of a step is the loss.

mod cauchy;
mod levenberg_marquardt;
mod linear;
mod normal_equations;
mod registration;

pub(crate) use cauchy::CauchyLoss;
pub(crate) use levenberg_marquardt::{Damping, LeastSquares, Minimum, Stop, Trial, minimise};
pub(crate) use linear::solve;
pub(crate) use normal_equations::NormalEquations;
pub(crate) use registration::RegistrationSums;
