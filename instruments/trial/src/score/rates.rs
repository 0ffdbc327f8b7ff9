//! Rates of right diagnoses, by the kind of case.

use serde::Serialize;

use super::outcome::{MODEL_TOO_SIMPLE, Outcome, UNEXPLAINED, UNKNOWN};
use super::statistics::{Rate, rate};

/// Rates of right diagnoses. "Single" cases have one effect of the library.
///
/// An effect counts as named if it is named itself, or if the data cannot distinguish it (see [`super::Setting`]) and the
/// verdict `ambiguous` names a class of at most three effects that holds it and the effect that looks alike.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rates {
    /// Single: the likeliest cause is the true one.
    pub single_top1: Rate,
    /// Single: the true cause and nothing else was added.
    pub single_exact: Rate,
    /// Single: the true cause is among the three likeliest.
    pub single_top3: Rate,
    /// Single: the true cause is the likeliest, or in a class of at most three that an ambiguous verdict names, whether or
    /// not the data could distinguish it.
    pub single_in_class: Rate,
    /// Pairs: both effects were added.
    pub pair_both: Rate,
    /// Three effects: at least two were added or are in a class of at most three.
    pub triple_two: Rate,
    /// Cases without a gap in which a gap was reported.
    pub false_alarms: Rate,
    /// Unknown causes with the verdict `unexplained`.
    pub unknown_unexplained: Rate,
    /// Unknown causes with `unknown` as the likeliest cause.
    pub unknown_first: Rate,
    /// Designs for which the fitted model is too simple, with the verdict `model_too_simple`.
    pub too_simple_found: Rate,
}

impl Rates {
    /// Counts over `outcomes`.
    pub(super) fn of<'a>(outcomes: impl IntoIterator<Item = &'a Outcome> + Clone) -> Self {
        let kind = |word: &'static str| {
            let all = outcomes.clone().into_iter();
            all.filter(move |o| o.answer.kind == word)
        };
        Self {
            single_top1: rate(kind("single"), |o| o.within_top(1)),
            single_exact: rate(kind("single"), Outcome::exactly_added),
            single_top3: rate(kind("single"), |o| o.within_top(3)),
            single_in_class: rate(kind("single"), Outcome::in_class),
            pair_both: rate(kind("pair"), Outcome::all_added),
            triple_two: rate(kind("triple"), |o| o.named_count() >= 2),
            false_alarms: rate(kind("none"), |o| !o.no_gap()),
            unknown_unexplained: rate(kind(UNKNOWN), |o| o.verdict == UNEXPLAINED),
            unknown_first: rate(kind(UNKNOWN), |o| !o.no_gap() && o.top_is_right()),
            too_simple_found: rate(kind("too_simple"), |o| o.verdict == MODEL_TOO_SIMPLE),
        }
    }
}
