//! Errors of the core packages: where, what is wrong, and what to do about it.

use std::fmt;

/// Result of an operation of the core packages.
pub type Result<T> = std::result::Result<T, Error>;

/// An error with its place, the problem there and a remedy.
///
/// Printed as `place: problem; remedy`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}; {remedy}")]
pub struct Error {
    kind: ErrorKind,
    /// The thing or field at fault, such as `optical_axis` or `channel R`.
    pub place: String,
    /// The problem, with the offending value.
    pub problem: String,
    /// The remedy: what the user can do.
    pub remedy: String,
}

/// The class of an [`Error`], for callers that react to errors rather than print them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A value, file or combination of settings that is not valid.
    InvalidInput,
    /// A valid request that this lens, model or version cannot serve.
    Unsupported,
    /// Too few usable observations for the result asked for.
    InsufficientData,
    /// The caller's progress callback or stop flag ended the operation; outputs are untouched.
    Cancelled,
}

impl Error {
    /// Creates an error of kind [`ErrorKind::InvalidInput`].
    pub fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            kind: ErrorKind::InvalidInput,
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// Creates the error of an `operation` that its caller cancelled.
    pub fn cancelled(operation: impl Into<String>) -> Self {
        Self::new(operation, "was stopped on request", "start it again")
            .with_kind(ErrorKind::Cancelled)
    }

    /// Returns the same error with another kind.
    #[must_use]
    pub fn with_kind(self, kind: ErrorKind) -> Self {
        Self { kind, ..self }
    }

    /// The class of the error.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// Returns whether the caller cancelled the operation.
    pub fn is_cancelled(&self) -> bool {
        self.kind == ErrorKind::Cancelled
    }

    /// Returns the same error with `outer` put before its place.
    #[must_use]
    pub fn within(mut self, outer: &str) -> Self {
        self.place = format!("{outer}: {}", self.place);
        self
    }
}

/// A fault in an observation set. Faults are collected, so that a user sees all of them at once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Index of the observation in its set; `None` for the set as a whole.
    pub observation: Option<usize>,
    /// The tile's file, as the manifest names it; empty for the set as a whole.
    pub file: String,
    /// The field at fault, such as `depth_m` or `channel R`.
    pub field: String,
    /// The problem, with the offending value.
    pub problem: String,
    /// The remedy: what the user can do.
    pub remedy: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(index) = self.observation {
            write!(f, "observation {index} ")?;
        }
        if !self.file.is_empty() {
            write!(f, "({}) ", self.file)?;
        }
        write!(f, "{}: {}; {}", self.field, self.problem, self.remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_survive_outer_places_and_leave_the_text_alone() {
        let cancelled = Error::cancelled("render").within("frame 3");
        assert!(cancelled.is_cancelled());
        assert_eq!(
            cancelled.to_string(),
            "frame 3: render: was stopped on request; start it again"
        );
        let invalid = Error::new("gamma", "is -1", "give a positive number");
        assert_eq!(invalid.kind(), ErrorKind::InvalidInput);
        let unsupported = invalid.clone().with_kind(ErrorKind::Unsupported);
        assert!(!unsupported.is_cancelled() && unsupported != invalid);
        assert_eq!(unsupported.to_string(), invalid.to_string());
    }
}
