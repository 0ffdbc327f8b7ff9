//! Faults of a photograph that would make its lens wrong: what they are, whether they can be allowed for, and what to do.
//!
//! These checks need nothing but a photograph, so that every kind of measurement can make them.

pub mod black_level;
pub mod direction;
pub mod greens;
pub mod noise_correlation;
pub mod two_lenses;

use seidel_optics::error::Error;

/// Whether a lens can be measured in spite of a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Severity {
    /// The lens would be wrong by more than its stated error.
    Refuse,
    /// The lens is less exact: the error of a pixel is this share of the peak of its light.
    Widen(f64),
    /// The lens is not affected.
    Note,
}

/// A fault of one photograph or of several.
#[derive(Debug, Clone, PartialEq)]
pub struct Concern {
    /// Whether a lens can be measured.
    pub severity: Severity,
    /// Place, fault and remedy.
    pub error: Error,
}

impl Concern {
    /// Creates a concern about the photograph called `name`.
    pub fn new(severity: Severity, name: &str, problem: String, remedy: &str) -> Self {
        let error = Error::new(format!("photograph {name}"), problem, remedy);
        Self { severity, error }
    }
}

/// Returns the first of `concerns` for which no lens should be measured.
pub fn refusal(concerns: &[Concern]) -> Option<&Error> {
    let mut refused = concerns.iter().filter(|c| c.severity == Severity::Refuse);
    refused.next().map(|concern| &concern.error)
}

/// Returns the error of a pixel that `concerns` add, as a share of the peak of its light.
pub fn added_error(concerns: &[Concern]) -> f64 {
    let shares = concerns.iter().map(|concern| match concern.severity {
        Severity::Widen(share) => share,
        Severity::Refuse | Severity::Note => 0.0,
    });
    shares.fold(0.0, f64::max)
}
