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

    /// Returns the normal equations at `point`. The problem may renew its weights and scales here.
    fn linearise(&mut self, point: &Self::Point) -> NormalEquations;

    /// Returns the cost at `point`, with the weights of the last linearisation.
    fn cost(&self, point: &Self::Point) -> f64;

    /// Applies `step` to the parameters of `point`, within their bounds.
    fn moved(&self, point: &Self::Point, step: &DVector<f64>) -> Self::Point;

    /// Returns the damped step from `point`; `None` where there is none.
    ///
    /// All parameters are free. A problem with fixed or bounded parameters solves for the free ones.
    fn damped_step(
        &self,
        _point: &Self::Point,
        equations: &NormalEquations,
        lambda: f64,
    ) -> Option<DVector<f64>> {
        let all: Vec<usize> = (0..equations.right.len()).collect();
        equations.damped_step(lambda, &all)
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

/// Convergence criteria. Both must be met by a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stop {
    /// Maximum number of iterations, at least 1.
    pub(crate) max_iterations: usize,
    /// Relative decrease of the cost below which a step counts as the last.
    pub(crate) min_decrease: f64,
    /// Euclidean length below which a step counts as the last, in the problem's units.
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
    problem: &mut P,
    start: P::Point,
    damping: Damping,
    stop: Stop,
) -> Minimum<P::Point> {
    let mut point = start;
    let mut lambda = FIRST_LAMBDA;
    let mut iteration = 1;
    loop {
        let equations = problem.linearise(&point);
        let Some(step) = descent_step(problem, &point, &equations, damping, &mut lambda) else {
            return Minimum {
                point,
                cost: equations.cost,
                last_equations: equations,
                converged: true,
            };
        };
        point = step.point;
        let converged = equations.cost - step.cost < stop.min_decrease * equations.cost
            && step.length < stop.min_step;
        if converged || iteration == stop.max_iterations {
            return Minimum {
                point,
                cost: step.cost,
                last_equations: equations,
                converged,
            };
        }
        iteration += 1;
    }
}

/// A step that lowers the cost.
struct DescentStep<Point> {
    point: Point,
    cost: f64,
    length: f64,
}

/// Raises `lambda` until a step lowers the cost.
fn descent_step<P: LeastSquares>(
    problem: &P,
    point: &P::Point,
    equations: &NormalEquations,
    damping: Damping,
    lambda: &mut f64,
) -> Option<DescentStep<P::Point>> {
    for _ in 0..damping.max_tries {
        let mut negligible = false;
        if let Some(step) = problem.damped_step(point, equations, *lambda) {
            let trial = problem.moved(point, &step);
            let cost = problem.cost(&trial);
            if cost < equations.cost {
                *lambda = (*lambda * DECREASE).max(damping.least);
                return Some(DescentStep {
                    point: trial,
                    cost,
                    length: step.norm(),
                });
            }
            negligible = (cost - equations.cost).abs() < damping.negligible_change * equations.cost;
        }
        *lambda *= damping.increase;
        if negligible || *lambda > MAX_LAMBDA {
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

        fn linearise(&mut self, &[x, y]: &[f64; 2]) -> NormalEquations {
            let jacobian = DMatrix::from_row_slice(2, 2, &[20.0 * x, -10.0, 1.0, 0.0]);
            let residuals = DVector::from_vec(vec![10.0 * (y - x * x), 1.0 - x]);
            let right = jacobian.transpose() * residuals;
            NormalEquations::new(jacobian.transpose() * jacobian, right, self.cost(&[x, y]))
        }

        fn cost(&self, &[x, y]: &[f64; 2]) -> f64 {
            100.0 * (x * x - y).powi(2) + (x - 1.0).powi(2)
        }

        fn moved(&self, point: &[f64; 2], step: &DVector<f64>) -> [f64; 2] {
            [point[0] + step[0], point[1] + step[1]]
        }
    }

    #[test]
    fn the_minimum_of_a_curved_valley_is_found() {
        let stop = Stop {
            max_iterations: 100,
            min_decrease: f64::INFINITY,
            min_step: 1e-9,
        };
        let found = minimise(&mut Rosenbrock, [-1.2, 1.0], DAMPING, stop);
        assert!(found.converged, "{found:?}");
        assert!((found.point[0] - 1.0).abs() < 1e-8 && (found.point[1] - 1.0).abs() < 1e-8);
    }

    #[test]
    fn iterations_end_at_their_maximum_and_at_a_small_decrease() {
        let start = [-1.2, 1.0];
        let few = minimise(&mut Rosenbrock, start, DAMPING, Stop::at_decrease(2, 0.0));
        assert!(!few.converged && few.cost < Rosenbrock.cost(&start));
        let one = minimise(&mut Rosenbrock, start, DAMPING, Stop::at_decrease(9, 1.0));
        assert!(one.converged && one.cost > 0.1, "{one:?}");
    }

    #[test]
    fn no_step_leads_away_from_the_minimum() {
        let found = minimise(
            &mut Rosenbrock,
            [1.0, 1.0],
            DAMPING,
            Stop::at_decrease(5, 0.0),
        );
        assert!(found.converged && found.point == [1.0, 1.0] && found.cost == 0.0);
    }
}
