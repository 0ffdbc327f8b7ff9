//! Calibration of probabilities.

use serde::Serialize;

use super::outcome::{Odds, Outcome};
use super::statistics::Measure;

/// Number of probability bins of the calibration error.
const BINS: usize = 15;

/// A bin of the calibration histogram: outcomes with probabilities in one of fifteen equal intervals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bin {
    /// Lower bound of the probability.
    pub from: f64,
    /// Number of outcomes.
    pub count: usize,
    /// Mean probability; 0 for an empty bin.
    pub confidence: f64,
    /// Share of correct outcomes; 0 for an empty bin.
    pub right: f64,
}

/// Returns the calibration histogram and the expected calibration error.
pub(super) fn calibrate(
    outcomes: &[Outcome],
    odds: impl Fn(&Outcome) -> Option<Odds>,
) -> (Vec<Bin>, Measure) {
    let mut sums = [(0_usize, 0.0, 0_usize); BINS];
    let with_gap = outcomes.iter().filter(|o| o.answer.kind != "none");
    for Odds { probability, right } in with_gap.filter_map(odds) {
        let bin = ((probability * BINS as f64).max(0.0) as usize).min(BINS - 1);
        sums[bin].0 += 1;
        sums[bin].1 += probability;
        sums[bin].2 += usize::from(right);
    }
    let bins: Vec<Bin> = sums
        .iter()
        .enumerate()
        .map(|(bin, &(count, confidence, right))| Bin {
            from: bin as f64 / BINS as f64,
            count,
            confidence: confidence / count.max(1) as f64,
            right: right as f64 / count.max(1) as f64,
        })
        .collect();
    let of: usize = bins.iter().map(|b| b.count).sum();
    let apart = |b: &Bin| b.count as f64 * (b.confidence - b.right).abs();
    let error = Measure {
        value: (of > 0).then(|| bins.iter().map(apart).sum::<f64>() / of as f64),
        of,
    };
    (bins, error)
}
