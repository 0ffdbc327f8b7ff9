//! A lens parameter as a function of object distance: a polynomial in vergence with interpolated residuals.

/// A polynomial in vergence v = 1 / distance (1/m), with standard errors of its coefficients and residuals at measured
/// distances.
#[derive(Debug, Clone, PartialEq)]
pub struct VergenceSeries {
    /// Coefficients of v^0, v^1 and so on; at least one.
    pub coefficients: Vec<f64>,
    /// Standard errors of the coefficients, as many; zero if unknown.
    pub sigma: Vec<f64>,
    /// Residuals (vergence, value) added to the polynomial, by increasing vergence: linear between, constant beyond.
    pub remainders: Vec<(f64, f64)>,
}

/// A value measured at one vergence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VergencePoint {
    /// Vergence, 1/m.
    pub vergence_per_m: f64,
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub sigma: f64,
}

impl VergenceSeries {
    /// Returns the least-squares line in vergence through `points`: a constant through one, zero through none.
    pub fn fit_line(points: &[VergencePoint]) -> Self {
        if points.is_empty() {
            return Self::constant(0.0);
        }
        let count = points.len() as f64;
        let mean_v = points.iter().map(|p| p.vergence_per_m).sum::<f64>() / count;
        let mean = points.iter().map(|p| p.value).sum::<f64>() / count;
        let deviation = |p: &VergencePoint| p.vergence_per_m - mean_v;
        let spread: f64 = points.iter().map(|p| deviation(p).powi(2)).sum();
        let mean_sigma = points.iter().map(|p| p.sigma.powi(2)).sum::<f64>().sqrt() / count;
        if spread == 0.0 {
            return Self {
                sigma: vec![mean_sigma],
                ..Self::constant(mean)
            };
        }
        let lever = |p: &VergencePoint| deviation(p) / spread;
        let slope: f64 = points.iter().map(|p| lever(p) * (p.value - mean)).sum();
        let slope_sigma = points
            .iter()
            .map(|p| (lever(p) * p.sigma).powi(2))
            .sum::<f64>()
            .sqrt();
        Self {
            sigma: vec![mean_sigma.hypot(slope_sigma * mean_v), slope_sigma],
            ..Self::new(vec![mean - slope * mean_v, slope])
        }
    }

    /// Creates a series with the same value at every distance.
    pub fn constant(value: f64) -> Self {
        Self::new(vec![value])
    }

    /// Creates a series from the coefficients of v^0, v^1 and so on, without standard errors.
    pub fn new(coefficients: Vec<f64>) -> Self {
        let sigma = vec![0.0; coefficients.len()];
        Self {
            coefficients,
            sigma,
            remainders: Vec::new(),
        }
    }

    /// Returns the value at vergence `v`, 1/m.
    pub fn at(&self, v: f64) -> f64 {
        let terms = self.coefficients.iter().rev();
        terms.fold(0.0, |sum, c| sum * v + c) + self.remainder(v)
    }

    /// Returns the value at vergence `v` of a series measured over `range`: linear beyond it.
    pub fn linear_beyond(&self, range: (f64, f64), v: f64) -> f64 {
        let clamped = v.clamp(range.0, range.1);
        self.at(clamped) + self.slope(clamped) * (v - clamped)
    }

    /// Returns the interpolated residual at vergence `v`.
    fn remainder(&self, v: f64) -> f64 {
        let all = &self.remainders;
        let (Some(first), Some(last)) = (all.first(), all.last()) else {
            return 0.0;
        };
        if v <= first.0 {
            return first.1;
        }
        let pairs = all.iter().zip(all.iter().skip(1));
        for (a, b) in pairs {
            if v <= b.0 {
                return a.1 + (b.1 - a.1) * (v - a.0) / (b.0 - a.0);
            }
        }
        last.1
    }

    /// Returns the derivative of the polynomial at vergence `v`.
    pub fn slope(&self, v: f64) -> f64 {
        let terms = self.coefficients.iter().enumerate().skip(1);
        terms
            .map(|(k, c)| k as f64 * c * v.powi(k as i32 - 1))
            .sum()
    }

    /// Returns the highest power of v.
    pub fn degree(&self) -> usize {
        self.coefficients.len().saturating_sub(1)
    }

    /// Returns the series `share` of the way from this one to `other`: this one at 0, `other` at 1. Errors are propagated as
    /// independent.
    #[must_use]
    pub fn towards(&self, other: &Self, share: f64) -> Self {
        let count = self.coefficients.len().max(other.coefficients.len());
        let pair = |a: &[f64], b: &[f64], k: usize| {
            let of = |all: &[f64]| all.get(k).copied().unwrap_or(0.0);
            [(1.0 - share) * of(a), share * of(b)]
        };
        let sum = |k| {
            pair(&self.coefficients, &other.coefficients, k)
                .iter()
                .sum()
        };
        let sigma = |k| {
            let [a, b] = pair(&self.sigma, &other.sigma, k);
            a.hypot(b)
        };
        let both = self.remainders.iter().chain(&other.remainders);
        let mut vergences: Vec<f64> = both.map(|(v, _)| *v).collect();
        vergences.sort_by(f64::total_cmp);
        vergences.dedup();
        let remainder = |v| (1.0 - share) * self.remainder(v) + share * other.remainder(v);
        Self {
            coefficients: (0..count).map(sum).collect(),
            sigma: (0..count).map(sigma).collect(),
            remainders: vergences.into_iter().map(|v| (v, remainder(v))).collect(),
        }
    }

    /// Returns the series whose value at v is that of this one at v times `factor`, which is above zero.
    #[must_use]
    pub fn stretched(&self, factor: f64) -> Self {
        let powers = || (0..).map(|power| factor.powi(power));
        let times_powers = |all: &[f64]| all.iter().zip(powers()).map(|(c, p)| c * p).collect();
        Self {
            coefficients: times_powers(&self.coefficients),
            sigma: times_powers(&self.sigma),
            remainders: (self.remainders.iter())
                .map(|(v, r)| (v / factor, *r))
                .collect(),
        }
    }

    /// Returns the series times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            coefficients: self.coefficients.iter().map(|c| c * factor).collect(),
            sigma: self.sigma.iter().map(|s| s * factor.abs()).collect(),
            remainders: self
                .remainders
                .iter()
                .map(|(v, r)| (*v, r * factor))
                .collect(),
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
    fn a_stretched_series_has_the_values_at_multiples() {
        let series = VergenceSeries {
            coefficients: vec![2.0, -1.0, 0.5, 3.0],
            sigma: vec![0.1, 0.2, 0.3, 0.4],
            remainders: vec![(0.5, 0.3), (1.0, -0.2)],
        };
        let stretched = series.stretched(1.6);
        for v in [0.0, 0.3, 0.5, 0.8, 2.0] {
            assert!((stretched.at(v) - series.at(1.6 * v)).abs() < 1e-12, "{v}");
        }
        assert_eq!(series.stretched(1.0), series);
    }

    #[test]
    fn a_series_between_two_has_values_between_theirs() {
        let a = VergenceSeries {
            remainders: vec![(0.2, 0.3), (1.0, -0.2)],
            ..VergenceSeries::new(vec![2.0, -1.0])
        };
        let b = VergenceSeries {
            remainders: vec![(0.5, 0.1)],
            ..VergenceSeries::new(vec![1.0, 3.0, 0.5])
        };
        for v in [0.0, 0.3, 0.5, 0.8, 2.0] {
            for share in [0.0, 0.4, 1.0, 3.0] {
                let want = a.at(v) + share * (b.at(v) - a.at(v));
                assert!((a.towards(&b, share).at(v) - want).abs() < 1e-12);
            }
        }
    }
}
