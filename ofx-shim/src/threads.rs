//! The threads of the plugin, which end before it is unloaded.

use seidel_core::Progress;
use seidel_threads::{RunError, Threads};

use crate::host::{Effect, Result};

static THREADS: Threads = Threads::new();

/// Runs `work` on as many threads as the host allows, and asks the host meanwhile whether to abort. Returns `None` if it
/// aborted.
///
/// # Errors
/// Those of `work`, and threads that cannot be started.
pub(crate) fn run<T: Send + 'static>(
    effect: &Effect,
    work: impl FnOnce(&Progress) -> seidel_core::Result<T> + Send + 'static,
) -> Result<Option<T>> {
    let go_on = |_| !effect.is_aborted();
    match THREADS.run(effect.host.threads(), go_on, work) {
        Ok(result) => Ok(Some(result?)),
        Err(RunError::Cancelled) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// Runs `work`, which is short, on one thread. The calling thread must not do it: it would start the global pool of
/// rayon, which outlives the plugin.
///
/// # Errors
/// Those of `work`, and a thread that cannot be started.
pub(crate) fn run_on_one<T: Send + 'static>(
    work: impl FnOnce() -> seidel_core::Result<T> + Send + 'static,
) -> Result<T> {
    Ok(THREADS.run(1, |_| true, |_| work())??)
}

/// Waits for all work and ends all threads.
pub(crate) fn end() {
    THREADS.end();
}

/// Ends all threads unless a render is under way.
pub(crate) fn end_if_idle() {
    THREADS.end_if_idle();
}
