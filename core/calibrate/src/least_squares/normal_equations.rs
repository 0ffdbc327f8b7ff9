//! The normal equations of a linearised problem, and their damped solution.

use nalgebra::{DMatrix, DVector};

/// Normal equations J'J d = J'r of a step d, with their damping.
#[derive(Debug, Clone)]
pub(crate) struct NormalEquations {
    /// J'J, with the Jacobian J of the prediction.
    pub(crate) matrix: DMatrix<f64>,
    /// J'r, with the residuals r = observed - predicted.
    pub(crate) right: DVector<f64>,
    /// Cost at the point of linearisation.
    pub(crate) cost: f64,
    /// Diagonal of D², which lambda multiplies.
    pub(crate) damping: DVector<f64>,
    /// Diagonal of the ridge, which is added whatever lambda is.
    pub(crate) ridge: DVector<f64>,
}

impl NormalEquations {
    /// Creates the equations with Marquardt's damping, the diagonal of `matrix`, and without a ridge.
    pub(crate) fn new(matrix: DMatrix<f64>, right: DVector<f64>, cost: f64) -> Self {
        Self {
            damping: matrix.diagonal(),
            ridge: DVector::zeros(right.len()),
            matrix,
            right,
            cost,
        }
    }

    /// Returns the step of the parameters `free`; the others stay in place.
    ///
    /// `None` where the damped matrix is not positive definite.
    pub(crate) fn damped_step(&self, lambda: f64, free: &[usize]) -> Option<DVector<f64>> {
        let count = free.len();
        let mut matrix = DMatrix::from_fn(count, count, |a, b| self.matrix[(free[a], free[b])]);
        for (a, &k) in free.iter().enumerate() {
            matrix[(a, a)] += lambda * self.damping[k] + self.ridge[k];
        }
        let right = DVector::from_fn(count, |a, _| self.right[free[a]]);
        let solution = matrix.cholesky()?.solve(&right);
        let mut step = DVector::zeros(self.right.len());
        for (&k, value) in free.iter().zip(solution.iter()) {
            step[k] = *value;
        }
        step.iter().all(|x| x.is_finite()).then_some(step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn equations() -> NormalEquations {
        let matrix = DMatrix::from_row_slice(3, 3, &[4.0, 2.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0]);
        NormalEquations::new(matrix, DVector::from_vec(vec![8.0, 7.0, 0.0]), 1.0)
    }

    #[test]
    fn fixed_parameters_stay_in_place() {
        let step = equations().damped_step(0.0, &[0, 1]).expect("definite");
        assert!((step - DVector::from_vec(vec![1.25, 1.5, 0.0])).norm() < 1e-12);
        let step = equations().damped_step(1.0, &[1]).expect("definite");
        assert!((step - DVector::from_vec(vec![0.0, 7.0 / 6.0, 0.0])).norm() < 1e-12);
        let step = equations().damped_step(1.0, &[]).expect("nothing to solve");
        assert_eq!(step, DVector::zeros(3));
    }

    #[test]
    fn a_ridge_holds_a_parameter_without_influence() {
        assert!(equations().damped_step(1.0, &[0, 1, 2]).is_none());
        let held = NormalEquations {
            ridge: DVector::from_element(3, 1e-12),
            ..equations()
        };
        let step = held.damped_step(0.0, &[0, 1, 2]).expect("definite");
        assert!(step[2] == 0.0 && (step[0] - 1.25).abs() < 1e-9);
    }
}
