//! Rates by the conditions of cases.

use std::collections::BTreeMap;

use serde::Serialize;

use super::outcome::Outcome;
use super::rates::Rates;

/// Upper ends of the gaps of weak and of medium cases.
const WEAK: f64 = 0.02;
const MEDIUM: f64 = 0.08;

/// The strength of a cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strength {
    /// A gap below 0.02.
    Weak,
    /// A gap from 0.02 to 0.08.
    Medium,
    /// A gap above 0.08.
    Strong,
}

impl Strength {
    /// Returns the strength of a gap; `None` for a gap of zero.
    pub fn of(gap: f64) -> Option<Self> {
        match gap {
            g if g <= 0.0 => None,
            g if g < WEAK => Some(Self::Weak),
            g if g <= MEDIUM => Some(Self::Medium),
            _ => Some(Self::Strong),
        }
    }

    /// Returns the identifier used in reports.
    pub fn id(self) -> &'static str {
        match self {
            Self::Weak => "weak",
            Self::Medium => "medium",
            Self::Strong => "strong",
        }
    }
}

/// Rates by the conditions of cases.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Breakdown {
    /// Rates by simulator.
    pub simulator: BTreeMap<String, Rates>,
    /// Rates by the number of object distances.
    pub distances: BTreeMap<String, Rates>,
    /// Rates by strength, over cases with a gap.
    pub strength: BTreeMap<String, Rates>,
}

impl Breakdown {
    /// Groups `outcomes`.
    pub(super) fn of(outcomes: &[Outcome]) -> Self {
        Self {
            simulator: grouped(outcomes, |o| Some(o.setting.simulator.clone())),
            distances: grouped(outcomes, |o| Some(o.setting.distances.to_string())),
            strength: grouped(outcomes, |o| {
                Strength::of(o.answer.gap).map(|strength| strength.id().to_owned())
            }),
        }
    }
}

/// Returns the rates of each group of outcomes with equal keys.
fn grouped(
    outcomes: &[Outcome],
    key: impl Fn(&Outcome) -> Option<String>,
) -> BTreeMap<String, Rates> {
    let mut groups: BTreeMap<String, Vec<&Outcome>> = BTreeMap::new();
    for outcome in outcomes {
        if let Some(key) = key(outcome) {
            groups.entry(key).or_default().push(outcome);
        }
    }
    let rates = |group: Vec<&Outcome>| Rates::of(group.iter().copied());
    groups
        .into_iter()
        .map(|(key, group)| (key, rates(group)))
        .collect()
}
