//! Rates, means and quantiles over cases.

use serde::Serialize;

use super::outcome::Outcome;

/// The rate at which a condition held.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rate {
    /// Number of cases in which it held.
    pub held: usize,
    /// Number of cases to which it applies.
    pub of: usize,
    /// `held` over `of`; none without cases.
    pub share: Option<f64>,
}

impl Rate {
    /// Creates the rate of `held` among `of` cases.
    pub fn new(held: usize, of: usize) -> Self {
        Self {
            held,
            of,
            share: (of > 0).then(|| held as f64 / of as f64),
        }
    }
}

/// A statistic over cases, such as a mean or a median.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Measure {
    /// The value; none without cases.
    pub value: Option<f64>,
    /// Number of cases.
    pub of: usize,
}

/// Returns how often `holds` is true over `outcomes`.
pub(super) fn rate<'a>(
    outcomes: impl Iterator<Item = &'a Outcome>,
    holds: impl Fn(&Outcome) -> bool,
) -> Rate {
    let (mut held, mut of) = (0, 0);
    for outcome in outcomes {
        of += 1;
        held += usize::from(holds(outcome));
    }
    Rate::new(held, of)
}

/// Returns the mean of `values`.
pub(super) fn mean(values: impl Iterator<Item = f64>) -> Measure {
    let values: Vec<f64> = values.collect();
    let of = values.len();
    Measure {
        value: (of > 0).then(|| values.iter().sum::<f64>() / of as f64),
        of,
    }
}

/// Returns the quantile of `values` at `share`, 0 to 1, interpolated linearly between order statistics.
pub(super) fn quantile(values: impl Iterator<Item = f64>, share: f64) -> Measure {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let of = values.len();
    let value = (of > 0).then(|| {
        let at = share * (of - 1) as f64;
        let (below, part) = (at as usize, at.fract());
        let above = (below + 1).min(of - 1);
        (1.0 - part) * values[below] + part * values[above]
    });
    Measure { value, of }
}
