//! A number of a lens that changes with object distance: a polynomial in vergence.

/// A polynomial in vergence v = 1 / distance (1/m), with standard errors of its coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct VergenceSeries {
    /// Coefficients of v^0, v^1 and so on; at least one.
    pub coefficients: Vec<f64>,
    /// Their standard errors, as many; zero where nothing is known of them.
    pub sigma: Vec<f64>,
}

impl VergenceSeries {
    /// The same value at every distance.
    pub fn constant(value: f64) -> Self {
        Self::new(vec![value])
    }

    /// These coefficients of v^0, v^1 and so on, without standard errors.
    pub fn new(coefficients: Vec<f64>) -> Self {
        let sigma = vec![0.0; coefficients.len()];
        Self {
            coefficients,
            sigma,
        }
    }

    /// The value at vergence `v`.
    pub fn at(&self, v: f64) -> f64 {
        self.coefficients
            .iter()
            .rev()
            .fold(0.0, |sum, c| sum * v + c)
    }

    /// The slope by v at vergence `v`.
    pub fn slope(&self, v: f64) -> f64 {
        let terms = self.coefficients.iter().enumerate().skip(1);
        terms
            .map(|(k, c)| k as f64 * c * v.powi(k as i32 - 1))
            .sum()
    }

    /// Highest power of v.
    pub fn degree(&self) -> usize {
        self.coefficients.len().saturating_sub(1)
    }

    /// The series whose value at v is this one's at v + `by`, exactly; errors as if they were
    /// independent.
    #[must_use]
    pub fn shifted(&self, by: f64) -> Self {
        let count = self.coefficients.len();
        let (mut coefficients, mut variances) = (vec![0.0; count], vec![0.0; count]);
        for (i, (c, s)) in self.coefficients.iter().zip(&self.sigma).enumerate() {
            // (v + by)^i, power by power from the highest.
            let mut share = 1.0;
            for j in (0..=i).rev() {
                coefficients[j] += share * c;
                variances[j] += (share * s).powi(2);
                share *= by * j as f64 / (i - j + 1) as f64;
            }
        }
        Self {
            coefficients,
            sigma: variances.into_iter().map(f64::sqrt).collect(),
        }
    }

    /// Every coefficient and error times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            coefficients: self.coefficients.iter().map(|c| c * factor).collect(),
            sigma: self.sigma.iter().map(|s| s * factor.abs()).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_and_slope_are_those_of_the_polynomial() {
        let series = VergenceSeries::new(vec![2.0, -1.0, 0.5]);
        assert_eq!(series.at(2.0), 2.0);
        assert_eq!(series.slope(2.0), 1.0);
        assert_eq!(series.degree(), 2);
        assert_eq!(VergenceSeries::constant(3.0).slope(1.0), 0.0);
    }

    #[test]
    fn a_shifted_series_is_the_same_further_on() {
        let series = VergenceSeries {
            coefficients: vec![2.0, -1.0, 0.5, 3.0],
            sigma: vec![0.1, 0.2, 0.3, 0.4],
        };
        let shifted = series.shifted(0.7);
        for v in [-1.0, 0.0, 0.4, 2.0] {
            assert!((shifted.at(v) - series.at(v + 0.7)).abs() < 1e-12, "{v}");
        }
        assert_eq!(series.shifted(0.0), series);
        assert_eq!(shifted.sigma[3], 0.4);
        assert!((shifted.sigma[2] - 0.3_f64.hypot(0.4 * 3.0 * 0.7)).abs() < 1e-12);
    }
}
