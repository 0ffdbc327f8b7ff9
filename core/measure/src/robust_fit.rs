//! Robust linear fit: least squares without outliers.

use nalgebra::{DMatrix, DVector};
use seidel_optics::numeric::scatter;

/// Coefficients of a robust linear fit, and their standard deviations.
pub(crate) struct LinearFit {
    pub(crate) coefficients: Vec<f64>,
    pub(crate) sigmas: Vec<f64>,
}

/// Fits `values` by the columns of `rows`, clipping outliers at four standard deviations.
pub(crate) fn linear_fit(rows: &[Vec<f64>], values: &[f64]) -> Option<LinearFit> {
    let terms = rows.first()?.len();
    let mut used: Vec<usize> = (0..values.len()).collect();
    let mut found = None;
    for _ in 0..8 {
        if used.len() < terms + 4 {
            break;
        }
        let matrix = DMatrix::from_fn(used.len(), terms, |r, c| rows[used[r]][c]);
        let right = DVector::from_fn(used.len(), |r, _| values[used[r]]);
        let normal = (matrix.transpose() * &matrix).cholesky()?;
        let solution = normal.solve(&(matrix.transpose() * right));
        let residual = |k: usize| {
            let row = rows[k].iter().zip(solution.iter());
            values[k] - row.map(|(a, b)| a * b).sum::<f64>()
        };
        let residuals: Vec<f64> = used.iter().map(|k| residual(*k)).collect();
        let freedom = used.len() - terms;
        let spread = scatter(&residuals) * (used.len() as f64 / freedom as f64).sqrt();
        let inverse = normal.inverse();
        let sigma = |k: usize| spread * inverse[(k, k)].sqrt();
        found = Some(LinearFit {
            coefficients: solution.iter().copied().collect(),
            sigmas: (0..terms).map(sigma).collect(),
        });
        let kept: Vec<usize> = (0..values.len())
            .filter(|k| residual(*k).abs() <= 4.0 * spread.max(1e-12))
            .collect();
        if kept == used {
            break;
        }
        used = kept;
    }
    found
}
