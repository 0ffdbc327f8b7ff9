//! The library's own threads. None outlives the last lens handle or `seidel_shutdown`, because its code must not run after
//! the library was unloaded.

use seidel_core::Progress;
use seidel_threads::{RunError, Threads};

use crate::callbacks::SeidelCallbacks;
use crate::guard::guard;
use crate::handles;
use crate::status::{Failure, Result, SeidelStatus};

static THREADS: Threads = Threads::new();

/// Ends all threads if there is neither a call nor a lens handle.
pub(crate) fn end_if_unused() {
    if !handles::any() {
        THREADS.end_if_idle();
    }
}

/// Calls [`end_if_unused`] when it is dropped, also by a panic.
struct EndIfUnused;

impl Drop for EndIfUnused {
    fn drop(&mut self) {
        end_if_unused();
    }
}

/// Does `work` on at most `limit` threads, or one for each core if it is 0, and calls the caller back meanwhile. Work owns
/// all its data, so that a caller who stops it can return at once while the work ends in the background.
///
/// # Panics
/// With the panic of `work`, which the guard of the export catches.
pub(crate) fn run<T: Send + 'static>(
    limit: u32,
    callbacks: &SeidelCallbacks,
    work: impl FnOnce(&Progress) -> Result<T> + Send + 'static,
) -> Result<T> {
    let _end = EndIfUnused;
    match THREADS.run(limit, |share| callbacks.report(share), work) {
        Ok(result) => result,
        Err(RunError::Cancelled) => Err(Failure::aborted()),
        Err(error @ RunError::Start { .. }) => Err(Failure::new(
            SeidelStatus::Memory,
            format!("settings.threads: {error}; set a lower limit"),
        )),
    }
}

/// Ends all threads of the library and waits for the work that they are doing. Call it before the library is
/// unloaded. It also happens when the last lens is released. The library remains usable: the next call starts threads
/// again.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_shutdown() -> SeidelStatus {
    guard(|| {
        THREADS.end();
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pointers::Versioned;

    #[test]
    fn panics_of_work_reach_the_guard_and_the_pool_goes_on() {
        let none = SeidelCallbacks::defaults();
        let status = guard(|| run(2, &none, |_| -> Result<()> { panic!("planted") }));
        assert_eq!(status, SeidelStatus::Panicked);
        let sum = run(2, &none, |_| Ok((1..=10).sum::<u32>()));
        assert_eq!(sum, Ok(55));
    }
}
