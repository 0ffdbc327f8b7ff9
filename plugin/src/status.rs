//! Status codes of the C ABI, and the failures behind them.

use seidel_core::{ErrorKind, Knob};

/// The result of a call. After any status but SEIDEL_STATUS_OK, `seidel_last_error` describes the failure, and images
/// are as they were before the call. Any function may return SEIDEL_STATUS_ARGUMENT for a NULL pointer that it does
/// not allow and for values out of range, SEIDEL_STATUS_UNSUPPORTED for a struct of a later version, and
/// SEIDEL_STATUS_PANICKED.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum SeidelStatus {
    /// The call succeeded.
    Ok = 0,
    /// An argument is not valid: a NULL pointer, a value out of range, a released handle, a sample that is not
    /// finite.
    Argument = 1,
    /// The lens profile cannot be read or is not valid.
    Lens = 2,
    /// This lens or this version of the library cannot do what the call asks for.
    Unsupported = 3,
    /// Memory ran out, or the call needs more than `memory` of the settings allows.
    Memory = 4,
    /// The progress callback stopped the call.
    Aborted = 5,
    /// An internal error of the library. Handles remain valid, and the process can go on calling it.
    Panicked = 6,
    /// A buffer is too small. The size needed was written.
    TooSmall = 7,
}

/// A failed call: its status, and the text for `seidel_last_error`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Failure {
    pub(crate) status: SeidelStatus,
    pub(crate) text: String,
}

pub(crate) type Result<T> = std::result::Result<T, Failure>;

impl Failure {
    pub(crate) fn new(status: SeidelStatus, text: impl Into<String>) -> Self {
        Self {
            status,
            text: text.into(),
        }
    }

    /// Creates the failure of an invalid argument: its name, the problem and the remedy.
    pub(crate) fn argument(name: &str, problem: impl std::fmt::Display, remedy: &str) -> Self {
        Self::new(
            SeidelStatus::Argument,
            format!("{name}: {problem}; {remedy}"),
        )
    }

    pub(crate) fn null(name: &str) -> Self {
        Self::argument(name, "is NULL", "give a pointer")
    }

    pub(crate) fn aborted() -> Self {
        Self::new(
            SeidelStatus::Aborted,
            "the progress callback stopped the call; call again to repeat it",
        )
    }

    pub(crate) fn panicked() -> Self {
        Self::new(
            SeidelStatus::Panicked,
            "an internal error of this library stopped the call; please report it with the call's arguments",
        )
    }
}

impl From<seidel_core::Error> for Failure {
    fn from(mut error: seidel_core::Error) -> Self {
        if let Some(knob) = Knob::named(&error.place) {
            error.place = format!("settings.{}", knob.identifier());
        }
        match error.kind() {
            ErrorKind::Cancelled => Self::aborted(),
            ErrorKind::Unsupported => Self::new(SeidelStatus::Unsupported, error.to_string()),
            _ => Self::new(SeidelStatus::Argument, error.to_string()),
        }
    }
}
