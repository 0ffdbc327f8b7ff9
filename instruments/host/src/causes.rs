//! Root causes: faults of several checks that have one text.

use std::collections::{BTreeMap, BTreeSet};

use crate::runner::Outcome;

/// A cause of faults.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cause {
    /// The fault, without the case in which a check met it if checks met it in several.
    pub text: String,
    /// Number of faults that it explains.
    pub faults: usize,
    /// Checks that found it, in the order in which they ended.
    pub checks: Vec<&'static str>,
}

/// A fault of a check.
struct Fault<'a> {
    check: &'static str,
    text: &'a str,
}

/// Returns the causes of all faults, those of most checks first.
///
/// Checks put the case before a fault, as in `rows Negative: 3 pixels not written`. Faults that end alike after such a case, but
/// for numbers, have one cause.
#[must_use]
pub fn root_causes(outcomes: &[Outcome]) -> Vec<Cause> {
    let faults: Vec<Fault<'_>> = (outcomes.iter())
        .flat_map(|outcome| {
            let texts = outcome.report.faults.iter();
            texts.map(|text| Fault {
                check: outcome.check,
                text,
            })
        })
        .collect();
    let mut users = BTreeMap::<String, BTreeSet<usize>>::new();
    for (index, fault) in faults.iter().enumerate() {
        for ending in endings(fault.text) {
            users
                .entry(without_numbers(ending))
                .or_default()
                .insert(index);
        }
    }
    let mut causes = Vec::<Cause>::new();
    let mut places = BTreeMap::<String, usize>::new();
    for fault in &faults {
        // The longest ending that others share, or else all of the text.
        let shared = endings(fault.text).find(|text| users[&without_numbers(text)].len() > 1);
        let text = shared.unwrap_or(fault.text);
        let place = *places.entry(without_numbers(text)).or_insert_with(|| {
            causes.push(Cause {
                text: text.to_owned(),
                faults: 0,
                checks: Vec::new(),
            });
            causes.len() - 1
        });
        let cause = &mut causes[place];
        cause.faults += 1;
        if !cause.checks.contains(&fault.check) {
            cause.checks.push(fault.check);
        }
    }
    causes.sort_by_key(|cause| std::cmp::Reverse(cause.checks.len()));
    causes
}

/// Returns `text`, and what is left of it after each colon, longest first.
fn endings(text: &str) -> impl Iterator<Item = &str> {
    std::iter::successors(Some(text), |rest| Some(rest.split_once(": ")?.1))
}

/// Returns `text` with `#` for every number.
fn without_numbers(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '0'..='9' if out.ends_with('#') => {}
            '0'..='9' => out.push('#'),
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::checks::Report;

    fn outcome(check: &'static str, faults: &[&str]) -> Outcome {
        Outcome {
            check,
            report: Report {
                faults: faults.iter().map(|text| (*text).to_owned()).collect(),
                skipped: Vec::new(),
            },
            duration: Duration::ZERO,
        }
    }

    #[test]
    fn faults_that_end_alike_are_one_cause_and_the_widest_comes_first() {
        let outcomes = [
            outcome("blur", &["the blur is too small", "no such property: Abc"]),
            outcome("tiles", &["tiles of 8: rows: 3 pixels not written"]),
            outcome(
                "fields",
                &[
                    "lower: rows: 17 pixels not written",
                    "upper: no such property: Abc",
                ],
            ),
            outcome("leaks", &["no such property: Abc"]),
            outcome("origin", &[]),
        ];
        let causes = root_causes(&outcomes);
        let found: Vec<_> = (causes.iter())
            .map(|cause| (cause.text.as_str(), cause.faults, cause.checks.len()))
            .collect();
        assert_eq!(
            found,
            [
                ("no such property: Abc", 3, 3),
                ("rows: 3 pixels not written", 2, 2),
                ("the blur is too small", 1, 1),
            ]
        );
        assert_eq!(causes[0].checks, ["blur", "fields", "leaks"]);
        assert!(root_causes(&[]).is_empty());
    }

    #[test]
    fn one_fault_keeps_its_case() {
        let causes = root_causes(&[outcome("tiles", &["tiles of 8: 3 pixels differ"])]);
        assert_eq!(causes[0].text, "tiles of 8: 3 pixels differ");
    }
}
