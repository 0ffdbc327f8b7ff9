//! Scores of diagnoses over many cases.

mod breakdown;
mod calibration;
mod outcome;
mod rates;
mod statistics;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use serde::Serialize;

pub use breakdown::{Breakdown, Strength};
pub use calibration::Bin;
pub use outcome::{Outcome, Setting};
pub use rates::Rates;
pub use statistics::{Measure, Rate};

use calibration::calibrate;
use statistics::{mean, quantile};

/// Scores over many outcomes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// Rates of right diagnoses.
    #[serde(flatten)]
    pub rates: Rates,
    /// Confusion matrix: counts by answer, then by diagnosis. Keys are effects joined by `+` in alphabetical order, `none`,
    /// `unknown`, `too_simple`, or the verdict if it names no cause.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Pairs: mean F1 score of the added effects.
    pub pair_f1: Measure,
    /// Median true share closed, over cases with all causes right.
    pub closed_median: Measure,
    /// Mean of |claimed - true| share closed, over cases with an added effect.
    pub closed_error: Measure,
    /// Expected calibration error of the printed probability of the diagnosis: that of all added effects, or of `unknown`.
    /// Cases without a gap and verdicts without a probability are left out.
    pub calibration_error: Measure,
    /// Expected calibration error of the likeliest cause alone. Probabilities sum to one, so each effect of a pair has
    /// about a half, however certain the pair is.
    pub calibration_error_first: Measure,
    /// Calibration histogram.
    pub calibration: Vec<Bin>,
    /// Median of the processor time, seconds, over cases with a measured one.
    pub cpu_seconds_median: Measure,
    /// 90th percentile of the processor time, seconds.
    pub cpu_seconds_p90: Measure,
    /// Median of the time taken, seconds.
    pub seconds_median: Measure,
    /// Longest time taken, seconds.
    pub seconds_longest: Measure,
    /// The rates by simulator, number of distances and strength.
    pub breakdown: Breakdown,
}

/// Computes the scores of a list of outcomes.
pub fn scores(outcomes: &[Outcome]) -> Scores {
    let kind = |word: &'static str| outcomes.iter().filter(move |o| o.answer.kind == word);
    let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for outcome in outcomes {
        let row = confusion.entry(outcome.truth()).or_default();
        *row.entry(outcome.named()).or_default() += 1;
    }
    let right = outcomes.iter().filter(|o| match o.answer.kind.as_str() {
        "single" => o.within_top(1),
        "pair" | "triple" => o.all_added(),
        _ => false,
    });
    let added = outcomes.iter().filter(|o| !o.added.is_empty());
    let (calibration, calibration_error) = calibrate(outcomes, Outcome::answer_odds);
    let (_, calibration_error_first) = calibrate(outcomes, Outcome::first_odds);
    let cpu = || outcomes.iter().filter_map(|o| o.cpu_seconds);
    let seconds = || outcomes.iter().map(|o| o.seconds);
    Scores {
        rates: Rates::of(outcomes),
        confusion,
        pair_f1: mean(kind("pair").map(Outcome::f1)),
        closed_median: quantile(right.map(|o| o.true_closed), 0.5),
        closed_error: mean(added.map(|o| (o.claimed_closed - o.true_closed).abs())),
        calibration_error,
        calibration_error_first,
        calibration,
        cpu_seconds_median: quantile(cpu(), 0.5),
        cpu_seconds_p90: quantile(cpu(), 0.9),
        seconds_median: quantile(seconds(), 0.5),
        seconds_longest: quantile(seconds(), 1.0),
        breakdown: Breakdown::of(outcomes),
    }
}
