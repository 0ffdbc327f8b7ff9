//! A smooth field through measured values: a robust polynomial of frame position.
//!
//! PSFs change over the field, most of all at its corners. A light is compared with this field, and not with the mean of
//! its neighbours, which would reject the corners.

use nalgebra::{DMatrix, DVector};

use seidel_optics::numeric::{dot, scatter};

/// Values per coefficient that a polynomial needs.
const VALUES_PER_TERM: f64 = 2.5;
/// Largest degree.
const MAX_DEGREE: usize = 4;
/// Clipping threshold in standard deviations, and the largest number of iterations.
const CLIP_SIGMAS: f64 = 4.5;
const MAX_ITERATIONS: usize = 12;

/// Departures of values from a smooth field.
#[derive(Debug, Clone, PartialEq)]
pub struct Departures {
    /// Value less field, one for each value.
    pub residuals: Vec<f64>,
    /// Standard deviation of those that follow the field.
    pub scatter: f64,
}

/// Fits a polynomial to `values` at `places` (about -1 to 1 along each axis), clipping outliers. `None` where there are too
/// few values for a second degree.
pub fn departures(places: &[[f64; 2]], values: &[f64], sigmas: &[f64]) -> Option<Departures> {
    let degree = (2..=MAX_DEGREE)
        .rev()
        .find(|d| values.len() as f64 >= VALUES_PER_TERM * terms(*d) as f64)?;
    let floor = 1e-12 + scatter(values) * 1e-6;
    let mut kept = vec![true; values.len()];
    let mut found = None;
    for _ in 0..MAX_ITERATIONS {
        let coefficients = solve(places, values, sigmas, &kept, degree)?;
        let residuals: Vec<f64> = (places.iter().zip(values))
            .map(|(place, value)| value - dot(&row(*place, degree), coefficients.as_slice()))
            .collect();
        let of_kept: Vec<f64> = (residuals.iter().zip(&kept))
            .filter_map(|(r, k)| k.then_some(*r))
            .collect();
        // A polynomial follows its values, so their scatter about it is too small.
        let freedom = 1.0 - terms(degree) as f64 / of_kept.len().max(terms(degree) + 1) as f64;
        let scatter = (scatter(&of_kept) / freedom.max(0.2).sqrt()).max(floor);
        let now: Vec<bool> = (residuals.iter().zip(sigmas))
            .map(|(r, sigma)| r.abs() < CLIP_SIGMAS * scatter.max(*sigma))
            .collect();
        let done = now == kept;
        found = Some(Departures { residuals, scatter });
        if done || now.iter().filter(|k| **k).count() < terms(degree) + 2 {
            break;
        }
        kept = now;
    }
    found
}

fn terms(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

fn row([x, y]: [f64; 2], degree: usize) -> Vec<f64> {
    (0..=degree)
        .flat_map(|m| (0..=degree - m).map(move |n| x.powi(m as i32) * y.powi(n as i32)))
        .collect()
}

fn solve(
    places: &[[f64; 2]],
    values: &[f64],
    sigmas: &[f64],
    kept: &[bool],
    degree: usize,
) -> Option<DVector<f64>> {
    let count = terms(degree);
    let mut normal = DMatrix::zeros(count, count);
    let mut right = DVector::zeros(count);
    let typical = seidel_optics::numeric::median(&mut sigmas.to_vec()).max(f64::MIN_POSITIVE);
    for k in (0..values.len()).filter(|k| kept[*k]) {
        let row = row(places[k], degree);
        // Bright lights are no better than the field is smooth.
        let weight = 1.0 / (1.0 + (sigmas[k] / typical).powi(2));
        for a in 0..count {
            right[a] += weight * row[a] * values[k];
            for b in 0..count {
                normal[(a, b)] += weight * row[a] * row[b];
            }
        }
    }
    for a in 0..count {
        normal[(a, a)] *= 1.0 + 1e-9;
    }
    normal.cholesky().map(|c| c.solve(&right))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outlier_departs_and_a_corner_does_not() {
        let places: Vec<[f64; 2]> = (0..64)
            .map(|k| [f64::from(k % 8) / 3.5 - 1.0, f64::from(k / 8) / 3.5 - 1.0])
            .collect();
        let mut values: Vec<f64> = (places.iter().enumerate())
            .map(|(k, [x, y])| {
                let r2 = x * x + y * y;
                2.0 + r2 + 0.5 * r2 * r2 + 0.01 * ((k * 37 % 11) as f64 - 5.0)
            })
            .collect();
        values[27] += 1.0;
        let found = departures(&places, &values, &[0.02; 64]).expect("enough values");
        assert!(found.residuals[27] > 10.0 * found.scatter);
        for corner in [0, 7, 56, 63] {
            assert!(found.residuals[corner].abs() < 4.0 * found.scatter);
        }
        assert!(departures(&places[..9], &values[..9], &[0.02; 9]).is_none());
    }
}
