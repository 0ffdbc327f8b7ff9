//! The Levenberg-Marquardt iteration for problems of few unknowns.

use nalgebra::{SMatrix, SVector};

/// Normal matrix of a linearised problem, and its right-hand side.
pub(super) type Equations<const N: usize> = (SMatrix<f64, N, N>, SVector<f64, N>);

/// Damping of the first step, its factors after steps that lower the cost and that do not, and its least value.
const FIRST_LAMBDA: f64 = 1e-3;
const DECREASE: f64 = 0.2;
const INCREASE: f64 = 8.0;
const MIN_LAMBDA: f64 = 1e-9;

/// Limits of the iterations.
pub(super) struct Limits {
    pub(super) iterations: usize,
    /// Steps tried in one iteration.
    pub(super) tries: usize,
    /// Relative decrease of the cost below which an iteration is the last.
    pub(super) min_gain: f64,
}

/// Minimises `cost` from `start`, with the `equations` of a step at a point and the point `moved` by a step. Returns the point and
/// its cost; `None` where a damped matrix is not positive definite.
pub(super) fn minimise<P, const N: usize>(
    start: P,
    cost: impl Fn(&P) -> f64,
    mut equations: impl FnMut(&P) -> Equations<N>,
    moved: impl Fn(&P, &SVector<f64, N>) -> P,
    limits: Limits,
) -> Option<(P, f64)> {
    let mut least = cost(&start);
    let (mut point, mut lambda) = (start, FIRST_LAMBDA);
    for _ in 0..limits.iterations {
        let (normal, right) = equations(&point);
        let mut gain = None;
        for _ in 0..limits.tries {
            let mut damped = normal;
            for k in 0..N {
                damped[(k, k)] *= 1.0 + lambda;
            }
            let step = damped.cholesky()?.solve(&right);
            let trial = moved(&point, &step);
            let now = cost(&trial);
            if now < least {
                gain = Some((least - now) / least);
                (point, least) = (trial, now);
                lambda = (lambda * DECREASE).max(MIN_LAMBDA);
                break;
            }
            lambda *= INCREASE;
        }
        if gain.is_none_or(|gain| gain < limits.min_gain) {
            break;
        }
    }
    Some((point, least))
}
