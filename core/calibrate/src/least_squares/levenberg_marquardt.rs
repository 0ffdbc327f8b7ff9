//! The Levenberg-Marquardt iteration.

use nalgebra::DVector;

use super::NormalEquations;

/// lambda of the first step.
const FIRST_LAMBDA: f64 = 1e-3;
/// Factor of lambda after a step that lowered the cost.
const DECREASE: f64 = 0.2;
/// lambda at which the search for a step ends: steps are then below rounding errors.
const MAX_LAMBDA: f64 = 1e12;

/// A nonlinear least-squares problem.
pub(crate) trait LeastSquares {
    /// Parameter values, with everything computed at them that the next iteration uses.
    type Point;

    /// Returns the normal equations at `point`.
    fn linearise(&self, point: &Self::Point) -> NormalEquations;

    /// Applies to `point` the step that solves its damped `equations`, within the bounds of the parameters.
    ///
    /// `None` where there is no solution.
    fn trial(&self, point: &Self::Point, equations: &NormalEquations)
    -> Option<Trial<Self::Point>>;
}

/// A point after a step.
pub(crate) struct Trial<Point> {
    point: Point,
    cost: f64,
    /// Euclidean length of the step, in the problem's units.
    length: f64,
}

impl<Point> Trial<Point> {
    /// Creates the trial `point` after `step`, with the `cost` there under the weights of the linearisation.
    pub(crate) fn new(point: Point, cost: f64, step: &DVector<f64>) -> Self {
        Self {
            point,
            cost,
            length: step.norm(),
        }
    }
}

/// Schedule of the damping parameter lambda, and the effort to find a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Damping {
    /// Factor of lambda after a step that did not lower the cost.
    pub(crate) increase: f64,
    /// Lower bound of lambda.
    pub(crate) least: f64,
    /// Maximum number of steps tried in one iteration.
    pub(crate) max_tries: usize,
    /// Relative change of the cost below which a rejected step is the last one tried.
    pub(crate) negligible_change: f64,
}

/// Convergence criteria. A step must meet both to count as the last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stop {
    /// Maximum number of iterations, at least 1.
    pub(crate) max_iterations: usize,
    /// Relative decrease of the cost below which the search has converged.
    pub(crate) min_decrease: f64,
    /// Length of a step below which the search has converged.
    pub(crate) min_step: f64,
}

impl Stop {
    /// Stops at a relative decrease of the cost below `min_decrease`, whatever the length of the step.
    pub(crate) const fn at_decrease(max_iterations: usize, min_decrease: f64) -> Self {
        Self {
            max_iterations,
            min_decrease,
            min_step: f64::INFINITY,
        }
    }
}

/// Result of a minimisation.
#[derive(Debug, Clone)]
pub(crate) struct Minimum<Point> {
    pub(crate) point: Point,
    /// Cost at `point`.
    pub(crate) cost: f64,
    /// Normal equations of the last iteration, before its step.
    pub(crate) last_equations: NormalEquations,
    /// Whether the convergence criteria were met, or no step lowered the cost.
    pub(crate) converged: bool,
}

/// Minimises the cost of `problem` from `start`.
pub(crate) fn minimise<P: LeastSquares>(
    problem: &P,
    start: P::Point,
    damping: Damping,
    stop: Stop,
) -> Minimum<P::Point> {
    let mut point = start;
    let mut lambda = FIRST_LAMBDA;
    let mut iterations = 0;
    loop {
        iterations += 1;
        let mut equations = problem.linearise(&point);
        equations.lambda = lambda;
        let (mut cost, mut converged) = (equations.cost, true);
        if let Some(trial) = lowering_step(problem, &point, &mut equations, damping) {
            lambda = (equations.lambda * DECREASE).max(damping.least);
            converged = equations.cost - trial.cost < stop.min_decrease * equations.cost
                && trial.length < stop.min_step;
            (point, cost) = (trial.point, trial.cost);
        }
        if converged || iterations == stop.max_iterations {
            return Minimum {
                point,
                cost,
                last_equations: equations,
                converged,
            };
        }
    }
}

/// Raises lambda until a step lowers the cost.
fn lowering_step<P: LeastSquares>(
    problem: &P,
    point: &P::Point,
    equations: &mut NormalEquations,
    damping: Damping,
) -> Option<Trial<P::Point>> {
    for _ in 0..damping.max_tries {
        let trial = problem.trial(point, equations);
        let change = trial.as_ref().map(|t| t.cost - equations.cost);
        if change.is_some_and(|c| c < 0.0) {
            return trial;
        }
        equations.lambda *= damping.increase;
        let negligible = damping.negligible_change * equations.cost;
        if equations.lambda > MAX_LAMBDA || change.is_some_and(|c| c.abs() < negligible) {
            break;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    const DAMPING: Damping = Damping {
        increase: 8.0,
        least: 1e-9,
        max_tries: 40,
        negligible_change: 0.0,
    };

    /// Rosenbrock's function as least squares: the predictions 10 (x² - y) and x of the values 0 and 1.
    struct Rosenbrock;

    impl LeastSquares for Rosenbrock {
        type Point = [f64; 2];

        fn linearise(&self, &[x, y]: &[f64; 2]) -> NormalEquations {
            let jacobian = DMatrix::from_row_slice(2, 2, &[20.0 * x, -10.0, 1.0, 0.0]);
            let right = jacobian.tr_mul(&DVector::from_vec(vec![10.0 * (y - x * x), 1.0 - x]));
            NormalEquations::new(jacobian.tr_mul(&jacobian), right, cost(&[x, y]))
        }

        fn trial(&self, point: &[f64; 2], equations: &NormalEquations) -> Option<Trial<[f64; 2]>> {
            let step = equations.damped_step(|_| true)?;
            let point = [point[0] + step[0], point[1] + step[1]];
            Some(Trial::new(point, cost(&point), &step))
        }
    }

    fn cost(&[x, y]: &[f64; 2]) -> f64 {
        100.0 * (x * x - y).powi(2) + (x - 1.0).powi(2)
    }

    #[test]
    fn the_minimum_of_a_curved_valley_is_found() {
        let stop = Stop {
            max_iterations: 100,
            min_decrease: f64::INFINITY,
            min_step: 1e-9,
        };
        let found = minimise(&Rosenbrock, [-1.2, 1.0], DAMPING, stop);
        assert!(found.converged, "{found:?}");
        assert!((found.point[0] - 1.0).abs() < 1e-8 && (found.point[1] - 1.0).abs() < 1e-8);
    }

    #[test]
    fn iterations_end_at_their_maximum_and_at_a_small_decrease() {
        let start = [-1.2, 1.0];
        let few = minimise(&Rosenbrock, start, DAMPING, Stop::at_decrease(2, 0.0));
        assert!(!few.converged && few.cost < cost(&start));
        let one = minimise(&Rosenbrock, start, DAMPING, Stop::at_decrease(9, 1.0));
        assert!(one.converged && one.cost > 0.1, "{one:?}");
    }

    #[test]
    fn no_step_leads_away_from_the_minimum() {
        let found = minimise(&Rosenbrock, [1.0, 1.0], DAMPING, Stop::at_decrease(5, 0.0));
        assert!(found.converged && found.point == [1.0, 1.0] && found.cost == 0.0);
    }
}
