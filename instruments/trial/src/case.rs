//! A case and its answer.

use std::collections::BTreeMap;

use seidel_optics::observations::ObservationSet;

/// The answer of a case: the causes of its gap.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// `none`, `single`, `pair`, `triple`, `unknown` or `too_simple`.
    pub kind: String,
    /// Identifiers of the effects; empty for `none`, `unknown` and `too_simple`.
    pub effects: Vec<String>,
    /// The family of the unknown cause, if there is one.
    pub unknown: Option<String>,
    /// Parameters of the causes, keyed `cause.parameter`; in pixels unless the name states another unit.
    pub parameters: BTreeMap<String, f64>,
    /// Mean over the real tiles, before noise, of |o - p|² / |o|². o is the tile of the real lens and p that of the bare
    /// lens at the same position of the pixel grid, both with unit sum. 0 without a cause.
    pub gap: f64,
}

/// A case: three observation sets and the answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// The simulated lens, without noise.
    pub design: ObservationSet,
    /// The real lens, with noise.
    pub real: ObservationSet,
    /// Other positions of the real lens, almost without noise.
    pub holdout: ObservationSet,
    /// The causes of the gap between the two.
    pub answer: Answer,
}

/// The sets of a case after a further capture.
#[derive(Debug, Clone, PartialEq)]
pub struct FurtherSets {
    /// The simulated lens, without noise.
    pub design: ObservationSet,
    /// The real lens, with noise.
    pub real: ObservationSet,
}
