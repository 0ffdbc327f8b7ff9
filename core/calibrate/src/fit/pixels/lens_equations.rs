//! Normal equations of the lens parameters that act on one tile or edge, and their sum.

use nalgebra::{DMatrix, DVector};

use super::parameters::ParameterLayout;

/// Normal equations of the lens parameters of one tile or edge.
#[derive(Debug, Clone)]
pub(in crate::fit) struct LensEquations {
    /// Normal matrix and right-hand side for the parameters listed in `parameters`.
    pub(in crate::fit) normal: DMatrix<f64>,
    pub(in crate::fit) right: DVector<f64>,
    pub(in crate::fit) parameters: Vec<usize>,
}

impl LensEquations {
    /// Returns the normal matrix of all parameters of `layout` and its right-hand side: the sum of the equations with their weights.
    pub(in crate::fit) fn total<'e>(
        layout: &ParameterLayout,
        weighted: impl Iterator<Item = (&'e Self, f64)>,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let count = layout.parameters.len();
        let mut normal = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        for (equations, weight) in weighted {
            for (a, &row) in equations.parameters.iter().enumerate() {
                right[row] += weight * equations.right[a];
                for (b, &column) in equations.parameters.iter().enumerate() {
                    normal[(row, column)] += weight * equations.normal[(a, b)];
                }
            }
        }
        (normal, right)
    }
}
