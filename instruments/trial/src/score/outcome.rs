//! The diagnosis of a case beside its answer.

use std::collections::BTreeSet;

use crate::case::Answer;

/// The verdict of no gap.
const NO_GAP: &str = "no_gap";
/// The verdict of a gap with several possible causes.
const AMBIGUOUS: &str = "ambiguous";
/// The verdict of a gap that no effect of the library explains.
pub(super) const UNEXPLAINED: &str = "unexplained";
/// The verdict of a lens whose model does not describe its own set.
pub(super) const MODEL_TOO_SIMPLE: &str = "model_too_simple";
/// The cause for everything outside the library.
pub(super) const UNKNOWN: &str = "unknown";
/// Largest class of indistinguishable causes that names its members.
const LARGEST_CLASS: usize = 3;
/// Effects that one object distance cannot distinguish.
const ALIKE_AT_ONE_DISTANCE: [&str; 2] = ["defocus_offset", "depth_scale"];

/// The conditions of a case by which scores are broken down.
///
/// At one object distance, `defocus_offset` and `depth_scale` look alike.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// Identifier of the simulator.
    pub simulator: String,
    /// Number of object distances.
    pub distances: usize,
}

/// The diagnosis of a case and its answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The answer.
    pub answer: Answer,
    /// The conditions of the case.
    pub setting: Setting,
    /// The verdict: `no_gap`, `unexplained`, `model_too_simple`, or another word for a gap that was explained.
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
    /// Processor time of all threads, seconds, where it can be measured.
    pub cpu_seconds: Option<f64>,
}

/// A probability and whether the answer that it belongs to is right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Odds {
    pub(super) probability: f64,
    pub(super) right: bool,
}

impl Outcome {
    pub(super) fn no_gap(&self) -> bool {
        self.verdict == NO_GAP
    }

    /// Returns the key of the answer in the confusion matrix.
    pub(super) fn truth(&self) -> String {
        match self.answer.kind.as_str() {
            "single" | "pair" | "triple" => joined(&self.answer.effects),
            other => other.to_owned(),
        }
    }

    /// Returns the key of the diagnosis in the confusion matrix.
    pub(super) fn named(&self) -> String {
        if self.no_gap() {
            "none".to_owned()
        } else if self.verdict == UNEXPLAINED {
            UNKNOWN.to_owned()
        } else if self.verdict == MODEL_TOO_SIMPLE {
            "too_simple".to_owned()
        } else if !self.added.is_empty() {
            joined(&self.added)
        } else {
            self.ranked
                .first()
                .map_or_else(|| self.verdict.clone(), |(id, _)| id.clone())
        }
    }

    /// Returns the classes of at most three causes, of which an ambiguous verdict names every member.
    fn small_classes(&self) -> impl Iterator<Item = &Vec<String>> {
        let ambiguous = self.verdict == AMBIGUOUS;
        let classes = self.equivalents.iter();
        classes.filter(move |class| ambiguous && class.len() <= LARGEST_CLASS)
    }

    /// Returns whether `cause` names `truth`: itself, or by a small class where the data cannot distinguish `truth`.
    fn names(&self, cause: &str, truth: &str) -> bool {
        let undecidable = self.setting.distances == 1 && ALIKE_AT_ONE_DISTANCE.contains(&truth);
        let holds = |class: &[String], id: &str| class.iter().any(|c| c == id);
        cause == truth
            || undecidable
                && self.small_classes().any(|class| {
                    holds(class, cause) && ALIKE_AT_ONE_DISTANCE.iter().all(|id| holds(class, id))
                })
    }

    /// Returns whether the one effect of a single case is among the first `count` causes.
    pub(super) fn within_top(&self, count: usize) -> bool {
        let Some(truth) = self.answer.effects.first() else {
            return false;
        };
        let mut first = self.ranked.iter().take(count);
        !self.no_gap() && first.any(|(cause, _)| self.names(cause, truth))
    }

    /// Returns whether the one effect of a single case comes first or is in a small class.
    pub(super) fn in_class(&self) -> bool {
        let mut classes = self.small_classes();
        self.within_top(1)
            || classes.any(|class| {
                self.answer
                    .effects
                    .iter()
                    .all(|truth| class.contains(truth))
            })
    }

    /// Returns whether the likeliest cause is a true one.
    pub(super) fn top_is_right(&self) -> bool {
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
    pub(super) fn first_odds(&self) -> Option<Odds> {
        let (_, probability) = self.ranked.first()?;
        Some(Odds {
            probability: *probability,
            right: self.top_is_right(),
        })
    }

    /// Returns the probability of the diagnosis as a whole, and whether it is right.
    ///
    /// For an explained gap and an ambiguous one, that is the sum over all added effects, which must be exactly the true
    /// ones: classes do not count, since each member has its own probability. For an unexplained gap, it is that of
    /// `unknown`. `None` without a gap or without causes, and for a model that is too simple, a verdict without odds.
    pub(super) fn answer_odds(&self) -> Option<Odds> {
        let odds_of = |id: &str| {
            let ranked = self.ranked.iter().find(|(cause, _)| cause == id);
            ranked.map_or(0.0, |(_, odds)| *odds)
        };
        if self.ranked.is_empty() || self.no_gap() || self.verdict == MODEL_TOO_SIMPLE {
            None
        } else if self.verdict == UNEXPLAINED {
            Some(Odds {
                probability: odds_of(UNKNOWN),
                right: self.answer.kind == UNKNOWN,
            })
        } else {
            let added: BTreeSet<&str> = self.added.iter().map(String::as_str).collect();
            let truths: BTreeSet<&str> = self.answer.effects.iter().map(String::as_str).collect();
            let sum: f64 = added.iter().map(|id| odds_of(id)).sum();
            Some(Odds {
                probability: sum.min(1.0),
                right: !added.is_empty() && added == truths,
            })
        }
    }

    /// Returns the printed probability of the diagnosis: the sum over all added effects, or that of an unknown cause. `None`
    /// for verdicts without one.
    pub fn probability(&self) -> Option<f64> {
        self.answer_odds().map(|odds| odds.probability)
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

    /// Returns the number of true effects that were added or are in a small class.
    pub(super) fn named_count(&self) -> usize {
        if self.no_gap() {
            return 0;
        }
        let named = |truth: &&String| {
            self.added.contains(truth) || self.small_classes().any(|class| class.contains(truth))
        };
        self.answer.effects.iter().filter(named).count()
    }

    /// Returns whether all true effects were added.
    pub(super) fn all_added(&self) -> bool {
        !self.no_gap() && self.found() == self.answer.effects.len()
    }

    /// Returns whether all true effects were added and nothing else.
    pub(super) fn exactly_added(&self) -> bool {
        let added: BTreeSet<&String> = self.added.iter().collect();
        self.all_added() && added.len() == self.answer.effects.len()
    }

    /// Returns the F1 score of the added effects.
    pub(super) fn f1(&self) -> f64 {
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
