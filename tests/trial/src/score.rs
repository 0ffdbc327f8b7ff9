//! Scores of diagnoses over many cases.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::case::Answer;

/// The verdict of no gap.
const NO_GAP: &str = "no_gap";
/// The verdict of a gap that no effect of the library explains.
const UNEXPLAINED: &str = "unexplained";
/// The cause for everything outside the library.
const UNKNOWN: &str = "unknown";
/// Largest class of indistinguishable causes that counts as naming its members.
const LARGEST_CLASS: usize = 2;
/// Number of probability bins of the calibration error.
const BINS: usize = 15;

/// The diagnosis of a case and its answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The answer.
    pub answer: Answer,
    /// The verdict: `no_gap`, `unexplained`, or any other word for a gap that was explained.
    pub verdict: String,
    /// The effects that the diagnosis added to the lens.
    pub added: Vec<String>,
    /// Causes, `unknown` among them, with their probabilities, likeliest first.
    pub ranked: Vec<(String, f64)>,
    /// Classes of causes that the diagnosis reports as indistinguishable.
    pub equivalents: Vec<Vec<String>>,
    /// Share of the gap closed according to the diagnosis.
    pub claimed_closed: f64,
    /// Share of the gap closed on the held-out set.
    pub true_closed: f64,
    /// Time taken, seconds.
    pub seconds: f64,
}

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

/// A statistic over cases, such as a mean or a median.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Measure {
    /// The value; none without cases.
    pub value: Option<f64>,
    /// Number of cases.
    pub of: usize,
}

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

/// Scores over many outcomes. "Single" cases have one effect of the library.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// Confusion matrix: counts by answer, then by diagnosis. Keys are effects joined by `+` in alphabetical order, `none`,
    /// `unknown`, or the verdict if it names no cause.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Single: the likeliest cause is the true one, or in a class of at most two with it.
    pub single_top1: Rate,
    /// Single: the likeliest cause is the true one.
    pub single_top1_exact: Rate,
    /// Single: the true cause is among the three likeliest, or in their classes of at most two.
    pub single_top3: Rate,
    /// Pairs: both effects were added, or others from their classes of at most two.
    pub pair_both: Rate,
    /// Pairs: mean F1 score of the added effects.
    pub pair_f1: Measure,
    /// Cases without a gap in which a gap was reported.
    pub false_alarms: Rate,
    /// Unknown causes with the verdict `unexplained`.
    pub unknown_unexplained: Rate,
    /// Unknown causes with `unknown` as the likeliest cause.
    pub unknown_first: Rate,
    /// Median true share closed, over cases with all causes right.
    pub closed_median: Measure,
    /// Mean of |claimed - true| share closed, over cases with an added effect.
    pub closed_error: Measure,
    /// Expected calibration error of the probability of the diagnosis: that of all added effects, or of `unknown`. Cases
    /// without a gap are left out.
    pub calibration_error: Measure,
    /// Expected calibration error of the likeliest cause alone. Probabilities sum to one, so each effect of a pair has
    /// about a half, however certain the pair is.
    pub calibration_error_first: Measure,
    /// Calibration histogram.
    pub calibration: Vec<Bin>,
    /// Median of the time taken, seconds.
    pub seconds_median: Measure,
    /// Longest time taken, seconds.
    pub seconds_longest: Measure,
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
        "pair" => o.both_named(),
        _ => false,
    });
    let added = outcomes.iter().filter(|o| !o.added.is_empty());
    let (calibration, calibration_error) = calibrate(outcomes, Outcome::answer_odds);
    let (_, calibration_error_first) = calibrate(outcomes, Outcome::first_odds);
    Scores {
        confusion,
        single_top1: rate(kind("single"), |o| o.within_top(1)),
        single_top1_exact: rate(kind("single"), |o| !o.no_gap() && o.top_is_right()),
        single_top3: rate(kind("single"), |o| o.within_top(3)),
        pair_both: rate(kind("pair"), Outcome::both_named),
        pair_f1: mean(kind("pair").map(Outcome::f1)),
        false_alarms: rate(kind("none"), |o| !o.no_gap()),
        unknown_unexplained: rate(kind(UNKNOWN), |o| o.verdict == UNEXPLAINED),
        unknown_first: rate(kind(UNKNOWN), |o| !o.no_gap() && o.top_is_right()),
        closed_median: median(right.map(|o| o.true_closed)),
        closed_error: mean(added.map(|o| (o.claimed_closed - o.true_closed).abs())),
        calibration_error,
        calibration_error_first,
        calibration,
        seconds_median: median(outcomes.iter().map(|o| o.seconds)),
        seconds_longest: Measure {
            value: outcomes.iter().map(|o| o.seconds).reduce(f64::max),
            of: outcomes.len(),
        },
    }
}

impl Outcome {
    fn no_gap(&self) -> bool {
        self.verdict == NO_GAP
    }

    fn truth(&self) -> String {
        match self.answer.kind.as_str() {
            "single" | "pair" => joined(&self.answer.effects),
            other => other.to_owned(),
        }
    }

    fn named(&self) -> String {
        if self.no_gap() {
            "none".to_owned()
        } else if self.verdict == UNEXPLAINED {
            UNKNOWN.to_owned()
        } else if !self.added.is_empty() {
            joined(&self.added)
        } else {
            self.ranked
                .first()
                .map_or_else(|| self.verdict.clone(), |(id, _)| id.clone())
        }
    }

    /// Returns whether the `cause` names `truth`, itself or by a small class that contains both.
    fn names(&self, cause: &str, truth: &str) -> bool {
        let has = |class: &[String], id: &str| class.iter().any(|c| c == id);
        cause == truth
            || self
                .equivalents
                .iter()
                .any(|c| c.len() <= LARGEST_CLASS && has(c, cause) && has(c, truth))
    }

    /// Returns whether the one effect of a single case is among the first `count` causes.
    fn within_top(&self, count: usize) -> bool {
        let Some(truth) = self.answer.effects.first() else {
            return false;
        };
        let mut first = self.ranked.iter().take(count);
        !self.no_gap() && first.any(|(cause, _)| self.names(cause, truth))
    }

    /// Returns whether the likeliest cause is a true one.
    fn top_is_right(&self) -> bool {
        let Some((top, _)) = self.ranked.first() else {
            return false;
        };
        if self.answer.kind == UNKNOWN {
            top == UNKNOWN
        } else {
            self.answer.effects.contains(top)
        }
    }

    /// Returns the probability of the likeliest cause, and whether it is right.
    fn first_odds(&self) -> Option<(f64, bool)> {
        let (_, odds) = self.ranked.first()?;
        Some((*odds, self.top_is_right()))
    }

    /// Returns the probability of the diagnosis as a whole, and whether it is right.
    ///
    /// For an explained gap, that is the sum over all added effects, which must be the true ones. For an unexplained gap,
    /// it is that of `unknown`. `None` without a gap or without causes.
    fn answer_odds(&self) -> Option<(f64, bool)> {
        let odds_of = |id: &str| {
            let ranked = self.ranked.iter().find(|(cause, _)| cause == id);
            ranked.map_or(0.0, |(_, odds)| *odds)
        };
        if self.ranked.is_empty() || self.no_gap() {
            None
        } else if self.verdict == UNEXPLAINED {
            Some((odds_of(UNKNOWN), self.answer.kind == UNKNOWN))
        } else {
            let added: BTreeSet<&str> = self.added.iter().map(String::as_str).collect();
            let odds: f64 = added.iter().map(|id| odds_of(id)).sum();
            let right = !added.is_empty()
                && added.len() == self.answer.effects.len()
                && self.found() == added.len();
            Some((odds.min(1.0), right))
        }
    }

    /// Returns the number of true effects that were added; each addition counts for at most one.
    fn found(&self) -> usize {
        let mut left: BTreeSet<&str> = self.added.iter().map(String::as_str).collect();
        let truths = &self.answer.effects;
        let (exact, loose): (Vec<_>, Vec<_>) = truths.iter().partition(|t| left.remove(t.as_str()));
        let by_class = loose.into_iter().filter(|truth| {
            let cause = left.iter().copied().find(|cause| self.names(cause, truth));
            cause.is_some_and(|cause| left.remove(cause))
        });
        exact.len() + by_class.count()
    }

    fn both_named(&self) -> bool {
        !self.no_gap() && self.found() == self.answer.effects.len()
    }

    fn f1(&self) -> f64 {
        let added: BTreeSet<&String> = self.added.iter().collect();
        if self.no_gap() {
            return 0.0;
        }
        2.0 * self.found() as f64 / (added.len() + self.answer.effects.len()) as f64
    }
}

/// Returns the identifiers in alphabetical order, joined by `+`.
fn joined(ids: &[String]) -> String {
    let ids: BTreeSet<&str> = ids.iter().map(String::as_str).collect();
    ids.into_iter().collect::<Vec<_>>().join("+")
}

fn rate<'a>(outcomes: impl Iterator<Item = &'a Outcome>, holds: impl Fn(&Outcome) -> bool) -> Rate {
    let (mut held, mut of) = (0, 0);
    for outcome in outcomes {
        of += 1;
        held += usize::from(holds(outcome));
    }
    Rate {
        held,
        of,
        share: (of > 0).then(|| held as f64 / of as f64),
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Measure {
    let values: Vec<f64> = values.collect();
    let of = values.len();
    Measure {
        value: (of > 0).then(|| values.iter().sum::<f64>() / of as f64),
        of,
    }
}

fn median(values: impl Iterator<Item = f64>) -> Measure {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let of = values.len();
    Measure {
        value: (of > 0).then(|| 0.5 * (values[(of - 1) / 2] + values[of / 2])),
        of,
    }
}

/// Returns the calibration histogram and the expected calibration error.
fn calibrate(
    outcomes: &[Outcome],
    odds: impl Fn(&Outcome) -> Option<(f64, bool)>,
) -> (Vec<Bin>, Measure) {
    let mut sums = [(0_usize, 0.0, 0_usize); BINS];
    let with_gap = outcomes.iter().filter(|o| o.answer.kind != "none");
    for (probability, right) in with_gap.filter_map(odds) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn strings(ids: &[&str]) -> Vec<String> {
        ids.iter().map(|&id| id.to_owned()).collect()
    }

    fn outcome(kind: &str, truth: &[&str], verdict: &str, ranked: &[(&str, f64)]) -> Outcome {
        Outcome {
            answer: Answer {
                kind: kind.to_owned(),
                effects: strings(truth),
                unknown: (kind == UNKNOWN).then(|| "ghost".to_owned()),
                parameters: BTreeMap::new(),
                gap: 0.1,
            },
            verdict: verdict.to_owned(),
            added: Vec::new(),
            ranked: ranked.iter().map(|(c, p)| ((*c).to_owned(), *p)).collect(),
            equivalents: Vec::new(),
            claimed_closed: 0.9,
            true_closed: 0.8,
            seconds: 2.0,
        }
    }

    #[test]
    fn causes_count_by_rank_and_by_small_classes() {
        let ranked = [("motion", 0.6), ("diffraction", 0.3), ("decentre", 0.1)];
        let right = outcome("single", &["motion"], "explained", &ranked);
        let third = outcome("single", &["decentre"], "explained", &ranked);
        let mut by_class = third.clone();
        by_class.equivalents = vec![strings(&["motion", "decentre"])];
        let mut by_crowd = third.clone();
        by_crowd.equivalents = vec![strings(&["motion", "decentre", "distortion"])];
        let denied = outcome("single", &["motion"], "no_gap", &ranked);
        let s = scores(&[right, third, by_class, by_crowd, denied]);
        assert_eq!((s.single_top1.held, s.single_top1.of), (2, 5));
        assert_eq!(s.single_top1_exact.held, 1);
        assert_eq!((s.single_top3.held, s.single_top3.share), (4, Some(0.8)));
        assert_eq!(s.closed_median.of, 2);
        assert_eq!(s.confusion["decentre"]["motion"], 3);
        assert_eq!(s.confusion["motion"]["none"], 1);
        assert_eq!(s.pair_f1.value, None);
    }

    #[test]
    fn pairs_need_both_each_addition_once() {
        let ranked = [("motion", 0.5)];
        let mut both = outcome("pair", &["motion", "decentre"], "explained", &ranked);
        both.added = strings(&["decentre", "motion"]);
        let mut one = both.clone();
        one.added = strings(&["motion"]);
        // One addition cannot count for both.
        one.equivalents = vec![strings(&["motion", "decentre"])];
        let mut by_class = both.clone();
        by_class.added = strings(&["motion", "sensor_tilt"]);
        by_class.equivalents = vec![strings(&["decentre", "sensor_tilt"])];
        let s = scores(&[both, one, by_class]);
        assert_eq!((s.pair_both.held, s.pair_both.of), (2, 3));
        let f1 = s.pair_f1.value.expect("three pairs");
        assert!((f1 - (2.0 + 2.0 / 3.0) / 3.0).abs() < 1e-12, "{f1}");
        assert_eq!(s.confusion["decentre+motion"]["decentre+motion"], 1);
        let error = s.closed_error.value.expect("three added");
        assert!((error - 0.1).abs() < 1e-12, "{error}");
    }

    #[test]
    fn odds_are_those_of_the_answer() {
        let ranked = [("motion", 0.5), ("decentre", 0.45), ("unknown", 0.05)];
        let mut both = outcome("pair", &["motion", "decentre"], "explained", &ranked);
        both.added = strings(&["decentre", "motion"]);
        let mut too_many = both.clone();
        too_many.answer = outcome("single", &["motion"], "", &[]).answer;
        let mut given_up = both.clone();
        given_up.verdict = UNEXPLAINED.to_owned();
        let odds: Vec<_> = [&both, &too_many, &given_up]
            .map(|o| o.answer_odds().expect("an answer"))
            .into();
        assert_eq!(odds, [(0.95, true), (0.95, false), (0.05, false)]);
        assert_eq!(
            outcome("pair", &["motion"], NO_GAP, &ranked).answer_odds(),
            None
        );
        let s = scores(&[both]);
        let [answer, first] = [s.calibration_error, s.calibration_error_first].map(|m| m.value);
        assert!((answer.expect("one") - 0.05).abs() < 1e-12);
        assert!((first.expect("one") - 0.5).abs() < 1e-12);
    }

    #[test]
    fn alarms_and_unknowns_are_counted() {
        let quiet = outcome("none", &[], "no_gap", &[("motion", 0.99)]);
        let alarm = outcome("none", &[], "explained", &[("motion", 0.99)]);
        let honest = outcome("unknown", &[], "unexplained", &[("unknown", 1.0)]);
        let mut fooled = outcome("unknown", &[], "explained", &[("motion", 0.7)]);
        fooled.added = strings(&["motion"]);
        let s = scores(&[quiet, alarm, honest, fooled]);
        assert_eq!((s.false_alarms.held, s.false_alarms.of), (1, 2));
        assert_eq!((s.unknown_unexplained.held, s.unknown_first.held), (1, 1));
        // One is right at 1, the other wrong at 0.7; cases without a gap do not count.
        let error = s.calibration_error.value.expect("two outcomes");
        assert!((error - 0.35).abs() < 1e-12, "{error}");
        assert_eq!(s.calibration_error.of, 2);
        assert_eq!(s.calibration_error_first, s.calibration_error);
        assert_eq!((s.calibration[14].count, s.calibration[10].count), (1, 1));
        assert_eq!(s.confusion["unknown"]["unknown"], 1);
        assert_eq!(s.seconds_median.value, Some(2.0));
    }

    #[test]
    fn no_outcomes_give_no_figures() {
        let s = scores(&[]);
        assert_eq!(s.single_top1.share, None);
        assert_eq!(s.calibration_error.value, None);
        assert_eq!(s.seconds_longest.value, None);
        // A failed diagnosis names nothing and is never right.
        let failed = scores(&[outcome("unknown", &[], "failed", &[])]);
        assert_eq!(failed.confusion["unknown"]["failed"], 1);
        assert_eq!(failed.unknown_unexplained.held, 0);
        assert!(
            serde_json::to_string(&s)
                .expect("plain values")
                .contains("confusion")
        );
    }
}
