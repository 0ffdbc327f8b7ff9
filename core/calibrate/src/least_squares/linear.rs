//! Linear least squares with standard errors.

use nalgebra::{DMatrix, DVector};

use seidel_optics::error::{Error, Result};

/// Solution of a linear least-squares problem.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LinearFit {
    /// Estimated coefficients.
    pub(crate) values: Vec<f64>,
    /// Standard errors from the residual variance.
    pub(crate) sigma: Vec<f64>,
}

/// Solves `rows . values = targets` by weighted least squares, using a singular value decomposition.
///
/// `weights` multiply rows and targets. Columns are scaled to unit norm internally, so units do not matter.
///
/// # Errors
/// Fewer rows than unknowns, or a rank-deficient matrix (relative singular value below 1e-9).
pub(crate) fn solve(rows: &[Vec<f64>], targets: &[f64], weights: &[f64]) -> Result<LinearFit> {
    let unknowns = rows.first().map_or(0, Vec::len);
    let undetermined = |problem: String| {
        Error::new(
            "least squares",
            problem,
            "give more observations, at more field positions",
        )
        .with_kind(seidel_optics::ErrorKind::InsufficientData)
    };
    if unknowns == 0 || rows.len() < unknowns {
        return Err(undetermined(format!(
            "has {} equations for {unknowns} unknowns",
            rows.len()
        )));
    }
    let matrix = DMatrix::from_fn(rows.len(), unknowns, |r, c| rows[r][c] * weights[r]);
    let target = DVector::from_fn(rows.len(), |r, _| targets[r] * weights[r]);
    let scales: Vec<f64> = matrix.column_iter().map(|c| c.norm()).collect();
    if let Some(column) = scales.iter().position(|s| !(*s > 0.0 && s.is_finite())) {
        return Err(undetermined(format!(
            "does not depend on unknown {}",
            column + 1
        )));
    }
    let scaled = DMatrix::from_fn(rows.len(), unknowns, |r, c| matrix[(r, c)] / scales[c]);
    let svd = scaled.clone().svd(true, true);
    let largest = svd.singular_values.max();
    if svd.singular_values.min() <= 1e-9 * largest {
        return Err(undetermined(
            "does not determine all its unknowns".to_owned(),
        ));
    }
    let solution = svd
        .solve(&target, 0.0)
        .map_err(|problem| undetermined(problem.to_owned()))?;
    let residual = &target - &scaled * &solution;
    let freedom = rows.len() - unknowns;
    let variance = if freedom > 0 {
        residual.norm_squared() / freedom as f64
    } else {
        0.0
    };
    let v = svd.v_t.as_ref().expect("V is computed");
    let sigma = (0..unknowns)
        .map(|c| {
            let spread: f64 = (0..unknowns)
                .map(|k| (v[(k, c)] / svd.singular_values[k]).powi(2))
                .sum();
            (variance * spread).sqrt() / scales[c]
        })
        .collect();
    Ok(LinearFit {
        values: (0..unknowns).map(|c| solution[c] / scales[c]).collect(),
        sigma,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_and_its_errors() {
        // y = 2 + 3 x with residuals +1, -1, -1, +1: textbook values by hand.
        let rows: Vec<Vec<f64>> = [0.0, 1.0, 2.0, 3.0].map(|x| vec![1.0, x]).to_vec();
        let targets = [3.0, 4.0, 7.0, 12.0];
        let fit = solve(&rows, &targets, &[1.0; 4]).expect("determined");
        assert!((fit.values[0] - 2.0).abs() < 1e-12 && (fit.values[1] - 3.0).abs() < 1e-12);
        // variance 4 / 2; sum (x - mean)² = 5.
        assert!((fit.sigma[1] - (2.0_f64 / 5.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn problems_that_do_not_determine_the_unknowns_are_refused() {
        let same = vec![vec![1.0, 2.0], vec![2.0, 4.0], vec![3.0, 6.0]];
        assert!(solve(&same, &[1.0; 3], &[1.0; 3]).is_err());
        assert!(solve(&[vec![1.0, 0.0]], &[1.0], &[1.0]).is_err());
        assert!(solve(&[vec![1.0, 0.0], vec![1.0, 0.0]], &[1.0; 2], &[1.0; 2]).is_err());
    }
}
