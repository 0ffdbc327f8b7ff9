//! A smooth field through measured values: a robust polynomial of frame position.
//!
//! PSFs change over the field, most of all at its corners. A light is compared with this field, and not with the mean of
//! its neighbours, which would reject the corners.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use seidel_optics::numeric::{dot, scatter};

/// Values per coefficient that a polynomial needs.
const VALUES_PER_TERM: f64 = 2.5;
/// Largest degree.
const MAX_DEGREE: usize = 4;
/// Clipping threshold in standard deviations, and the largest number of iterations.
const CLIP_SIGMAS: f64 = 4.5;
const MAX_ITERATIONS: usize = 12;
/// Least share of its own departure that a value shows.
const MIN_FREEDOM: f64 = 0.1;

/// Departures of values from a smooth field.
#[derive(Debug, Clone, PartialEq)]
pub struct Departures {
    /// Value less field, one for each value; over the root of one less its leverage where the value took part in the fit, since a
    /// polynomial follows single values at the border of the frame.
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
        let fit = solve(places, values, sigmas, &kept, degree)?;
        let residuals: Vec<f64> = (0..values.len())
            .map(|k| {
                let own = row(places[k], degree);
                let departure = values[k] - dot(&own, fit.coefficients.as_slice());
                let leverage = if kept[k] {
                    fit.leverage(&own, sigmas[k])
                } else {
                    0.0
                };
                departure / (1.0 - leverage).max(MIN_FREEDOM).sqrt()
            })
            .collect();
        let of_kept: Vec<f64> = (residuals.iter().zip(&kept))
            .filter_map(|(r, k)| k.then_some(*r))
            .collect();
        let scatter = scatter(&of_kept).max(floor);
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
) -> Option<FieldFit> {
    let count = terms(degree);
    let mut normal = DMatrix::zeros(count, count);
    let mut right = DVector::zeros(count);
    let typical = seidel_optics::numeric::median(&mut sigmas.to_vec()).max(f64::MIN_POSITIVE);
    for k in (0..values.len()).filter(|k| kept[*k]) {
        let row = row(places[k], degree);
        let weight = weight(sigmas[k], typical);
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
    let cholesky = normal.cholesky()?;
    Some(FieldFit {
        coefficients: cholesky.solve(&right),
        cholesky,
        typical,
    })
}

/// Returns the weight of a value: bright lights are no better than the field is smooth.
fn weight(sigma: f64, typical: f64) -> f64 {
    1.0 / (1.0 + (sigma / typical).powi(2))
}

/// A polynomial through the values, with its normal equations.
struct FieldFit {
    coefficients: DVector<f64>,
    cholesky: Cholesky<f64, Dyn>,
    /// Median standard deviation of the values.
    typical: f64,
}

impl FieldFit {
    /// Returns the share of a value in the field at its own place.
    fn leverage(&self, row: &[f64], sigma: f64) -> f64 {
        let row = DVector::from_column_slice(row);
        weight(sigma, self.typical) * row.dot(&self.cholesky.solve(&row))
    }
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
