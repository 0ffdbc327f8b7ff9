//! Results of a self-test: the diagnosis of every case beside its true answer.

use seidel_trial::{Outcome, Rate, Scores, Size, scores};
use serde::Serialize;

/// Verdict on a case that could not be fitted or diagnosed; it counts as wrong whatever the truth.
pub(super) const FAILED: &str = "failed";
/// Verdict that no known effect closes the gap.
const UNEXPLAINED: &str = "unexplained";

/// The results of a self-test.
#[derive(Debug, Clone)]
pub struct SelfTest {
    /// Seed from which all cases are drawn.
    pub seed: u64,
    /// Number of places of each case, and its tile size.
    pub size: Size,
    /// All cases, in the order drawn.
    pub cases: Vec<CaseResult>,
    /// Whether cases with a single effect were diagnosed again without that effect in the library.
    pub withhold: bool,
}

/// The result of one case.
#[derive(Debug, Clone)]
pub struct CaseResult {
    /// The diagnosis and the true answer; the verdict is `failed` where there is no diagnosis.
    pub outcome: Outcome,
    /// Error of the fit or of the diagnosis.
    pub error: Option<String>,
    /// The second diagnosis, of single effects when [`SelfTest::withhold`] is set.
    pub withheld: Option<WithheldResult>,
}

/// The diagnosis of a case whose true effect was withheld from the library.
#[derive(Debug, Clone, Serialize)]
pub struct WithheldResult {
    /// The verdict; `failed` where there is no diagnosis.
    pub verdict: String,
    /// Effects that were added instead.
    pub added: Vec<String>,
    /// Time taken, seconds.
    pub seconds: f64,
    /// Error of the fit or of the diagnosis.
    pub error: Option<String>,
}

impl SelfTest {
    /// Returns the scores over all cases.
    pub fn scores(&self) -> Scores {
        let outcomes: Vec<Outcome> = self.cases.iter().map(|c| c.outcome.clone()).collect();
        scores(&outcomes)
    }

    /// Returns the number of cases diagnosed correctly.
    pub fn right(&self) -> usize {
        self.cases.iter().filter(|c| c.is_right()).count()
    }

    /// Returns the number of cases that could not be fitted or diagnosed.
    pub fn failed(&self) -> usize {
        self.cases.iter().filter(|c| c.error.is_some()).count()
    }

    /// Returns how often a gap was called unexplained while its effect was withheld; `None` unless
    /// [`SelfTest::withhold`] is set.
    pub fn withheld_unexplained(&self) -> Option<Rate> {
        let withheld = self.cases.iter().filter_map(|c| c.withheld.as_ref());
        let verdicts: Vec<&str> = withheld.map(|w| w.verdict.as_str()).collect();
        let of = verdicts.len();
        let held = verdicts.iter().filter(|v| **v == UNEXPLAINED).count();
        self.withhold.then(|| Rate {
            held,
            of,
            share: (of > 0).then(|| held as f64 / of as f64),
        })
    }
}

impl CaseResult {
    /// Returns whether the diagnosis is right in the sense of the scores: the single effect comes first, both effects of a
    /// pair are added, no gap is found between equal lenses, or an unknown cause is called unexplained.
    pub fn is_right(&self) -> bool {
        let own = scores(std::slice::from_ref(&self.outcome));
        let no_alarm = own.false_alarms.of - own.false_alarms.held;
        own.single_top1.held + own.pair_both.held + own.unknown_unexplained.held + no_alarm == 1
    }

    /// Returns a description of the difference between the real lens of the case and its design.
    pub fn truth(&self) -> String {
        let answer = &self.outcome.answer;
        match (&answer.unknown, answer.effects.as_slice()) {
            (Some(family), _) => format!("unknown: {family}"),
            (None, []) => "nothing".to_owned(),
            (None, effects) => effects.join(" and "),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::self_test;
    use super::CaseResult;

    #[test]
    fn right_and_failed_cases_are_counted() {
        let mut test = self_test();
        let right: Vec<bool> = test.cases.iter().map(CaseResult::is_right).collect();
        assert_eq!(
            right,
            [true, false, true, false, true, false, true, false, false]
        );
        assert_eq!((test.right(), test.failed()), (4, 1));
        let withheld = test.withheld_unexplained().expect("withhold is set");
        assert_eq!((withheld.held, withheld.of), (1, 3));
        assert_eq!(test.cases[2].truth(), "motion and decentre");
        test.withhold = false;
        assert!(test.withheld_unexplained().is_none());
    }
}
