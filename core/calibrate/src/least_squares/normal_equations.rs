//! The damped normal equations of a linearised problem, and their solution.

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
    /// Damping parameter.
    pub(crate) lambda: f64,
    /// Diagonal of D², which lambda multiplies.
    pub(crate) damping: DVector<f64>,
    /// Diagonal of the ridge, which is added whatever lambda is.
    pub(crate) ridge: DVector<f64>,
}

impl NormalEquations {
    /// Creates the equations with Marquardt's D², the diagonal of `matrix`, with lambda 0 and without a ridge.
    pub(crate) fn new(matrix: DMatrix<f64>, right: DVector<f64>, cost: f64) -> Self {
        Self {
            lambda: 0.0,
            damping: matrix.diagonal(),
            ridge: DVector::zeros(right.len()),
            matrix,
            right,
            cost,
        }
    }

    /// Returns the step of the parameters that are `free`; the others stay in place.
    ///
    /// `None` where the damped matrix is not positive definite.
    pub(crate) fn damped_step(&self, free: impl Fn(usize) -> bool) -> Option<DVector<f64>> {
        let free: Vec<usize> = (0..self.right.len()).filter(|&k| free(k)).collect();
        let mut matrix = self.matrix.select_rows(&free).select_columns(&free);
        for (a, &k) in free.iter().enumerate() {
            matrix[(a, a)] += self.lambda * self.damping[k] + self.ridge[k];
        }
        let solution = matrix.cholesky()?.solve(&self.right.select_rows(&free));
        let mut step = DVector::zeros(self.right.len());
        for (&k, value) in free.iter().zip(&solution) {
            step[k] = *value;
        }
        step.iter().all(|x| x.is_finite()).then_some(step)
    }

    /// Returns [`Self::damped_step`], solved in units of the parameters that give the matrix a unit diagonal
    /// (Marquardt 1963).
    pub(crate) fn scaled_step(&self, free: impl Fn(usize) -> bool) -> Option<DVector<f64>> {
        let count = self.right.len();
        let unit = |square: f64| if square > 0.0 { square.sqrt() } else { 1.0 };
        let units = self.matrix.diagonal().map(unit);
        let scaled = |a: usize, b: usize| self.matrix[(a, b)] / (units[a] * units[b]);
        let scaled = Self {
            matrix: DMatrix::from_fn(count, count, scaled),
            right: self.right.component_div(&units),
            damping: DVector::from_element(count, 1.0),
            ridge: self.ridge.component_div(&units.component_mul(&units)),
            ..*self
        };
        Some(scaled.damped_step(free)?.component_div(&units))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn equations(lambda: f64) -> NormalEquations {
        let matrix = DMatrix::from_row_slice(3, 3, &[4.0, 2.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0]);
        NormalEquations {
            lambda,
            ..NormalEquations::new(matrix, DVector::from_vec(vec![8.0, 7.0, 0.0]), 1.0)
        }
    }

    #[test]
    fn fixed_parameters_stay_in_place() {
        let step = equations(0.0).damped_step(|k| k < 2).expect("definite");
        assert!((step - DVector::from_vec(vec![1.25, 1.5, 0.0])).norm() < 1e-12);
        let step = equations(1.0).damped_step(|k| k == 1).expect("definite");
        assert!((step - DVector::from_vec(vec![0.0, 7.0 / 6.0, 0.0])).norm() < 1e-12);
        let step = equations(1.0)
            .damped_step(|_| false)
            .expect("nothing to solve");
        assert_eq!(step, DVector::zeros(3));
    }

    #[test]
    fn a_ridge_holds_a_parameter_without_influence() {
        assert!(equations(1.0).damped_step(|_| true).is_none());
        let held = NormalEquations {
            ridge: DVector::from_element(3, 1e-12),
            ..equations(0.0)
        };
        let step = held.damped_step(|_| true).expect("definite");
        assert!(step[2] == 0.0 && (step[0] - 1.25).abs() < 1e-9);
    }

    #[test]
    fn scaled_and_unscaled_steps_agree() {
        let free = |k| k < 2;
        let plain = equations(0.3).damped_step(free).expect("definite");
        let scaled = equations(0.3).scaled_step(free).expect("definite");
        assert!((plain - scaled).norm() < 1e-12);
    }
}
