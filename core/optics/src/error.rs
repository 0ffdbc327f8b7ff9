//! What can go wrong with values handed to this crate, and how it is said.

use std::fmt;

/// Result of an operation of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// A refusal: where, what is wrong, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}; {remedy}")]
pub struct Error {
    /// The thing or field at fault, such as `optical_axis` or `channel R`.
    pub place: String,
    /// What is wrong with it, with the offending value.
    pub problem: String,
    /// What the user can do.
    pub remedy: String,
}

impl Error {
    /// A refusal that names the `place`, its `problem` and the `remedy`.
    pub fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            place: place.into(),
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// The same refusal seen from further out: `outer` is put before the place.
    #[must_use]
    pub fn within(mut self, outer: &str) -> Self {
        self.place = format!("{outer}: {}", self.place);
        self
    }
}

/// One bad thing in an observation set. Faults are collected so that a user sees all of them at once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Index of the observation in its set; `None` for the set as a whole.
    pub observation: Option<usize>,
    /// The tile's file, as the manifest names it; empty for the set as a whole.
    pub file: String,
    /// The field at fault, such as `depth_m` or `channel R`.
    pub field: String,
    /// What is wrong, with the offending value.
    pub problem: String,
    /// What the user can do.
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
