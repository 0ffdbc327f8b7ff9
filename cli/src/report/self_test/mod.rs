//! A self-test put down: what a diagnosis got right over many sealed cases.

mod aims;
mod cases;
mod confusion;
mod drawings;
mod json;
#[cfg(test)]
mod made;
mod page;

use seidel_core::trial::{Outcome, Rate, Scores, Size, scores};

pub use aims::{Aim, Bound, Figure};
pub use json::json;
pub use page::html;

/// The verdict on a case that could not be fitted or diagnosed: wrong, whatever its truth.
pub const FAILED: &str = "failed";
/// The verdict that no known effect closes the gap.
const UNEXPLAINED: &str = "unexplained";
/// Causes of a case that are told.
const TOLD: usize = 3;

/// What came of many sealed cases.
#[derive(Debug, Clone)]
pub struct SelfTest {
    /// All cases follow from it.
    pub seed: u64,
    /// How large every case was.
    pub size: Size,
    /// Every case that was drawn, in order.
    pub cases: Vec<Tested>,
    /// Whether single effects were left out of the library in a second pass.
    pub withhold: bool,
}

/// What came of one case.
#[derive(Debug, Clone)]
pub struct Tested {
    /// What was said, and what was true; verdict [`FAILED`] where nothing could be said.
    pub outcome: Outcome,
    /// What stood in the way of a fit or a diagnosis.
    pub failure: Option<String>,
    /// What was said without the true effect in the library, of single effects where that was asked for.
    pub withheld: Option<Withheld>,
}

/// What was said of a case while its effect was not in the library.
#[derive(Debug, Clone)]
pub struct Withheld {
    /// The verdict; [`FAILED`] where there is none.
    pub verdict: String,
    /// Effects that were added instead.
    pub added: Vec<String>,
    /// What stood in the way.
    pub failure: Option<String>,
    /// Time taken, seconds.
    pub seconds: f64,
}

impl SelfTest {
    /// The figures over all cases.
    pub fn scores(&self) -> Scores {
        let outcomes: Vec<Outcome> = self.cases.iter().map(|c| c.outcome.clone()).collect();
        scores(&outcomes)
    }

    /// Cases that were answered rightly.
    pub fn right(&self) -> usize {
        self.cases.iter().filter(|c| c.is_right()).count()
    }

    /// Cases that could not be fitted or diagnosed.
    pub fn failed(&self) -> usize {
        self.cases.iter().filter(|c| c.failure.is_some()).count()
    }

    /// How often an effect that the library lacked was called unexplained; none unless that was asked for.
    pub fn withheld_unexplained(&self) -> Option<Rate> {
        let withheld: Vec<&Withheld> = self
            .cases
            .iter()
            .filter_map(|c| c.withheld.as_ref())
            .collect();
        let (of, held) = (
            withheld.len(),
            withheld.iter().filter(|w| w.is_right()).count(),
        );
        self.withhold.then(|| Rate {
            held,
            of,
            share: (of > 0).then(|| held as f64 / of as f64),
        })
    }
}

impl Tested {
    /// Whether the answer is right in the sense of the scores: the effect likeliest, both effects added, no gap
    /// where there is none, and what is unknown called unexplained.
    pub fn is_right(&self) -> bool {
        let own = scores(std::slice::from_ref(&self.outcome));
        let quiet = own.false_alarms.of - own.false_alarms.held;
        own.single_top1.held + own.pair_both.held + own.unknown_unexplained.held + quiet == 1
    }

    /// What separates the real lens of the case from its design, in words.
    pub fn truth(&self) -> String {
        let answer = &self.outcome.answer;
        match (&answer.unknown, answer.effects.as_slice()) {
            (Some(family), _) => format!("unknown: {family}"),
            (None, []) => "nothing".to_owned(),
            (None, effects) => effects.join(" and "),
        }
    }
}

impl Withheld {
    /// Whether the effect that the library lacked was called unexplained.
    pub fn is_right(&self) -> bool {
        self.verdict == UNEXPLAINED
    }
}

#[cfg(test)]
mod tests {
    use super::made::self_test;

    #[test]
    fn rights_and_failures_are_counted_over_all_cases() {
        let made = self_test();
        let right: Vec<bool> = made.cases.iter().map(super::Tested::is_right).collect();
        assert_eq!(
            right,
            [true, false, true, false, true, false, true, false, false]
        );
        assert_eq!((made.right(), made.failed()), (4, 1));
        let withheld = made.withheld_unexplained().expect("asked for");
        assert_eq!((withheld.held, withheld.of), (1, 3));
        assert_eq!(made.cases[2].truth(), "motion and decentre");
        let mut never = made;
        never.withhold = false;
        assert!(never.withheld_unexplained().is_none());
    }
}
