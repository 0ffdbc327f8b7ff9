//! What every call answers.

/// What became of a call. `seidel_last_error` says why in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum SeidelStatus {
    /// All went well.
    Ok = 0,
    /// A null pointer, a size or value that cannot be, a handle that is none, or a sample that is not finite.
    Argument = 1,
    /// A lens profile that cannot be read, or is none.
    Lens = 2,
    /// What was asked for cannot be done with this lens, or by this version.
    Unsupported = 3,
    /// Memory ran out, or more would be needed than the settings allow.
    Memory = 4,
    /// The progress callback said to stop. Outputs are untouched.
    Aborted = 5,
    /// A fault of this library. The handle and the process can go on being used.
    Panicked = 6,
    /// The buffer is too small; how large it must be was stored.
    TooSmall = 7,
}

/// Why a call fails.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Failure {
    pub(crate) status: SeidelStatus,
    pub(crate) text: String,
}

use seidel_core::ErrorKind;

pub(crate) type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    pub(crate) fn new(status: SeidelStatus, text: impl Into<String>) -> Self {
        Self {
            status,
            text: text.into(),
        }
    }

    /// A bad argument: which, what is wrong with it, and what to do.
    pub(crate) fn argument(name: &str, problem: impl std::fmt::Display, remedy: &str) -> Self {
        Self::new(
            SeidelStatus::Argument,
            format!("{name}: {problem}; {remedy}"),
        )
    }

    pub(crate) fn aborted() -> Self {
        Self::new(
            SeidelStatus::Aborted,
            "the progress callback said to stop; call again",
        )
    }

    pub(crate) fn panicked() -> Self {
        Self::new(
            SeidelStatus::Panicked,
            "a fault of this library stopped the call; please report it, with what was asked for",
        )
    }
}

impl From<seidel_core::Error> for Failure {
    fn from(error: seidel_core::Error) -> Self {
        match error.kind() {
            ErrorKind::Cancelled => Self::aborted(),
            ErrorKind::Unsupported => Self::new(SeidelStatus::Unsupported, error.to_string()),
            _ => Self::new(SeidelStatus::Argument, error.to_string()),
        }
    }
}
