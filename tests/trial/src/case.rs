//! A drawn case and its answer.

use std::collections::BTreeMap;

use seidel_optics::observations::ObservationSet;

/// What is to be found out about a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// `none`, `single`, `pair` or `unknown`.
    pub kind: String,
    /// The effects in it, by identifier; empty for `none` and `unknown`.
    pub effects: Vec<String>,
    /// The family of an unknown cause.
    pub unknown: Option<String>,
    /// The numbers behind it, as `cause.number`; pixels unless the name says otherwise.
    pub parameters: BTreeMap<String, f64>,
    /// Mean over the real tiles, before noise, of |o - p|² / |o|², with o the real and p the bare lens's tile
    /// at the same place of the pixel grid, both of unit sum; 0 where nothing is missing.
    pub gap: f64,
}

/// One sealed case.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// What the user simulated: the bare lens, without noise.
    pub design: ObservationSet,
    /// What the camera saw, with noise.
    pub real: ObservationSet,
    /// Other places as the camera sees them, nearly without noise.
    pub holdout: ObservationSet,
    /// What separates the two.
    pub answer: Answer,
}
