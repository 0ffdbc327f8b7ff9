//! Panics of an export, which must not leave it.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `work` of an export without a status; returns `fallback` if it panics. The last error is unchanged.
pub(crate) fn guard_or<T>(fallback: T, work: impl FnOnce() -> T) -> T {
    catch_panic(work).unwrap_or(fallback)
}

/// Returns the result of `work`, or `None` if it panics.
pub(crate) fn catch_panic<T>(work: impl FnOnce() -> T) -> Option<T> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(result) => Some(result),
        Err(payload) => {
            // Dropping an unknown payload could panic again.
            std::mem::forget(payload);
            None
        }
    }
}
