//! Work without the GIL, with progress, Ctrl-C and cancellation.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use seidel_core::Progress;
use seidel_threads::{RunError, Threads};

use crate::error::{Failure, Result};

/// The threads of one process.
struct ProcessThreads {
    process: u32,
    threads: &'static Threads,
}

static THREADS: Mutex<Option<ProcessThreads>> = Mutex::new(None);

/// Returns the threads of this process. A forked process has none of the threads of its parent, so it gets its own.
///
/// The caller holds the GIL, as does a thread of Python that forks: the lock is never copied while it is held.
fn threads(_py: Python<'_>) -> &'static Threads {
    let process = std::process::id();
    let mut guard = THREADS.lock().unwrap_or_else(PoisonError::into_inner);
    match &*guard {
        Some(own) if own.process == process => own.threads,
        _ => {
            // Those of a parent process are left alone: they cannot be joined here.
            let threads: &'static Threads = Box::leak(Box::default());
            *guard = Some(ProcessThreads { process, threads });
            threads
        }
    }
}

/// The number of threads of a call, and its progress callback.
pub(crate) struct CallOptions<'a, 'py> {
    /// Most threads; 0 for one each core.
    pub(crate) threads: u32,
    /// Called with the share done, 0 to 1; ends the work by an exception or by returning `False`.
    pub(crate) progress: Option<&'a Bound<'py, PyAny>>,
}

impl CallOptions<'_, '_> {
    /// Does `work` on threads of the package and returns its result.
    ///
    /// The calling thread releases the GIL. About fifty times a second it answers signals, so that Ctrl-C ends the work, and
    /// calls the progress callback. Work that was cancelled may run on for a moment; its result is dropped.
    ///
    /// # Errors
    /// Those of `work`, exceptions of the callback and of signal handlers, cancellation, and a panic of `work`.
    pub(crate) fn run<T: Send + 'static>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Progress) -> Result<T> + Send + 'static,
    ) -> Result<T> {
        let callback = self.progress.map(|callback| callback.clone().unbind());
        let limit = self.threads;
        let threads = threads(py);
        let raised: Mutex<Option<PyErr>> = Mutex::new(None);
        let report = |share: f64| match Python::attach(|py| report(py, callback.as_ref(), share)) {
            Ok(goes_on) => goes_on,
            Err(error) => {
                *raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
                false
            }
        };
        let run = || catch_unwind(AssertUnwindSafe(|| threads.run(limit, report, work)));
        let outcome = py.detach(run);
        if let Some(error) = raised.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(error.into());
        }
        match outcome {
            Ok(Ok(result)) => result,
            Ok(Err(RunError::Cancelled)) => Err(Failure::cancelled()),
            Ok(Err(error @ RunError::Start { .. })) => Err(Failure::argument(
                "threads",
                error.to_string(),
                "set a lower limit",
            )),
            Err(panic) => {
                // Dropping an unknown payload could panic again.
                std::mem::forget(panic);
                Err(Failure::Panic)
            }
        }
    }
}

/// Answers signals and calls the callback; returns whether to go on.
fn report(py: Python<'_>, callback: Option<&Py<PyAny>>, share: f64) -> PyResult<bool> {
    py.check_signals()?;
    let Some(callback) = callback else {
        return Ok(true);
    };
    let answer = callback.call1(py, (share,))?;
    // Callbacks usually return nothing.
    Ok(!answer.bind(py).is(pyo3::types::PyBool::new(py, false)))
}
