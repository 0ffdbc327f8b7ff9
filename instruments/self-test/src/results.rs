//! Results of a self-test: the diagnosis of every case beside its true answer.

use seidel_trial::{Outcome, Rate, Recipe, Scores, Selection, scores};
use serde::Serialize;

/// Verdict on a case that could not be fitted or diagnosed; it counts as wrong whatever the truth.
pub(crate) const FAILED: &str = "failed";
/// Verdict that no known effect closes the gap.
const UNEXPLAINED: &str = "unexplained";

/// The results of a self-test.
#[derive(Debug, Clone)]
pub(crate) struct SelfTest {
    /// The selection from which the cases are drawn.
    pub(crate) selection: Selection,
    /// The cases that were run, in the order drawn.
    pub(crate) cases: Vec<CaseResult>,
    /// Whether cases with a single effect were diagnosed again without that effect in the library.
    pub(crate) withhold: bool,
}

/// The result of one case.
#[derive(Debug, Clone)]
pub(crate) struct CaseResult {
    /// Index of the case in its selection.
    pub(crate) index: usize,
    /// The recipe.
    pub(crate) recipe: Recipe,
    /// The diagnosis and the true answer; the verdict is `failed` where there is no diagnosis.
    pub(crate) outcome: Outcome,
    /// Gap that the fitted lens leaves of its own design; `None` where there is no diagnosis.
    pub(crate) own_gap: Option<f64>,
    /// Detection limit according to the diagnosis; `None` where there is none.
    pub(crate) detection_limit: Option<f64>,
    /// Error of the fit or of the diagnosis.
    pub(crate) error: Option<String>,
    /// The second diagnosis, of single effects when [`SelfTest::withhold`] is set.
    pub(crate) withheld: Option<WithheldResult>,
    /// The diagnosis with the advised capture, of ambiguous cases.
    pub(crate) advised: Option<AdvisedResult>,
    /// Processor time of the fit alone, seconds, where it can be measured.
    pub(crate) fit_cpu_seconds: Option<f64>,
}

/// The diagnosis of an ambiguous case with the capture that was advised.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct AdvisedResult {
    /// Identifier of the capture.
    pub(crate) capture: &'static str,
    /// The verdict; null if the capture is not simulated.
    pub(crate) verdict: Option<String>,
    /// Effects that were added.
    pub(crate) added: Vec<String>,
    /// Whether the true answer is given and nothing else; null if the capture is not simulated.
    pub(crate) settled: Option<bool>,
}

/// The diagnosis of a case whose true effect was withheld from the library.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct WithheldResult {
    /// The verdict; `failed` where there is no diagnosis.
    pub(crate) verdict: String,
    /// Effects that were added instead.
    pub(crate) added: Vec<String>,
    /// Time taken, seconds.
    pub(crate) seconds: f64,
    /// Error of the fit or of the diagnosis.
    pub(crate) error: Option<String>,
}

impl SelfTest {
    /// Returns the scores over all cases.
    pub(crate) fn scores(&self) -> Scores {
        let outcomes: Vec<Outcome> = self.cases.iter().map(|c| c.outcome.clone()).collect();
        scores(&outcomes)
    }

    /// Returns the number of cases diagnosed correctly.
    pub(crate) fn right(&self) -> usize {
        self.cases.iter().filter(|c| c.is_right()).count()
    }

    /// Returns the number of cases that could not be fitted or diagnosed.
    pub(crate) fn failed(&self) -> usize {
        self.cases.iter().filter(|c| c.error.is_some()).count()
    }

    /// Returns how often the advised capture settled an ambiguity, of those that are simulated.
    pub(crate) fn advised_settled(&self) -> Rate {
        let advised = self.cases.iter().filter_map(|c| c.advised.as_ref());
        let settled: Vec<bool> = advised.filter_map(|a| a.settled).collect();
        let held = settled.iter().filter(|s| **s).count();
        Rate::new(held, settled.len())
    }

    /// Returns how often a gap was called unexplained while its effect was withheld; `None` unless
    /// [`SelfTest::withhold`] is set.
    pub(crate) fn withheld_unexplained(&self) -> Option<Rate> {
        let withheld = self.cases.iter().filter_map(|c| c.withheld.as_ref());
        let verdicts: Vec<&str> = withheld.map(|w| w.verdict.as_str()).collect();
        let of = verdicts.len();
        let held = verdicts.iter().filter(|v| **v == UNEXPLAINED).count();
        self.withhold.then(|| Rate::new(held, of))
    }
}

impl CaseResult {
    /// Returns whether the diagnosis is right in the sense of the scores: the single effect comes first, both effects of a
    /// pair are added, two of three effects are named, no gap is found between equal lenses, an unknown cause is called
    /// unexplained, or a model that is too simple is called so.
    pub(crate) fn is_right(&self) -> bool {
        let own = scores(std::slice::from_ref(&self.outcome)).rates;
        let no_alarm = own.false_alarms.of - own.false_alarms.held;
        let found = [
            own.single_top1,
            own.pair_both,
            own.triple_two,
            own.unknown_unexplained,
            own.too_simple_found,
        ];
        no_alarm + found.iter().map(|rate| rate.held).sum::<usize>() == 1
    }

    /// Returns a description of the difference between the real lens of the case and its design.
    pub(crate) fn truth(&self) -> String {
        let answer = &self.outcome.answer;
        match (&answer.unknown, answer.effects.as_slice()) {
            (Some(family), _) => format!("unknown: {family}"),
            (None, []) if answer.kind == "too_simple" => "model too simple".to_owned(),
            (None, []) => "nothing".to_owned(),
            (None, effects) => effects.join(" and "),
        }
    }

    /// Returns the result on one line.
    pub(crate) fn line(&self) -> String {
        let (o, c) = (&self.outcome, &self.recipe.conditions);
        let right = if self.is_right() { "right" } else { "WRONG" };
        let number = |value: Option<f64>, digits: usize| {
            value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
        };
        let added = match o.added.as_slice() {
            [] => "nothing".to_owned(),
            ids => ids.join(" and "),
        };
        let ideal = if c.ideal_positions {
            ""
        } else {
            ", no ideal positions"
        };
        format!(
            "case {}: {right}; {} -> {}, added {added}, odds {}; gap {:.4}, closed {:.3} of {:.3}; {}, {} x {} tiles of {} px, \
             SNR {:.0}{ideal}; {:.1} s, {} CPU s, {} of them for the fit",
            self.index,
            self.truth(),
            o.verdict,
            number(o.probability(), 2),
            o.answer.gap,
            o.claimed_closed,
            o.true_closed,
            o.setting.simulator,
            c.distances,
            c.size.real,
            c.size.tile,
            c.snr,
            o.seconds,
            number(o.cpu_seconds, 1),
            number(self.fit_cpu_seconds, 1),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::CaseResult;
    use crate::samples::self_test;

    #[test]
    fn right_and_failed_cases_are_counted() {
        let mut test = self_test();
        let right: Vec<bool> = test.cases.iter().map(CaseResult::is_right).collect();
        assert_eq!(
            right,
            [
                true, false, true, false, true, false, true, false, false, true, true, false
            ]
        );
        assert_eq!((test.right(), test.failed()), (6, 1));
        let withheld = test.withheld_unexplained().expect("withhold is set");
        assert_eq!((withheld.held, withheld.of), (1, 3));
        assert_eq!(test.cases[2].truth(), "motion and decentre");
        assert_eq!(test.cases[10].truth(), "model too simple");
        let line = test.cases[1].line();
        assert!(
            line.starts_with(
                "case 1: WRONG; higher_order -> explained, added vignetting, odds 0.94; gap 0.1200"
            ),
            "{line}"
        );
        assert!(
            line.ends_with("12.5 s, 20.0 CPU s, 4.0 of them for the fit"),
            "{line}"
        );
        let settled = test.advised_settled();
        assert_eq!((settled.held, settled.of), (1, 2));
        test.withhold = false;
        assert!(test.withheld_unexplained().is_none());
    }
}
