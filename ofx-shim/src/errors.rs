//! Errors of the core and of the thread pools as failures of an action.

use seidel_threads::RunError;

use crate::host::Failure;

impl From<seidel_core::Error> for Failure {
    fn from(error: seidel_core::Error) -> Self {
        Self::failed(error.to_string())
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Cancelled => Self::failed(error.to_string()),
            RunError::Start { .. } => Self::memory(format!(
                "Seidel {error}; close other programs, or let the host use fewer processors."
            )),
        }
    }
}
