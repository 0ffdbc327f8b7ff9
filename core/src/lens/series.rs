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
}
