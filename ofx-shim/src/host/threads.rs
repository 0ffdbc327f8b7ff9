//! How many threads to work with.

use super::Host;

impl Host {
    /// As many as the host allows; 0, all that there are, where it does not say. Resolve has no more than a dummy that
    /// counts one (openfx-supportext).
    pub(crate) fn threads(&self) -> u32 {
        let allowed = self.suites.multi_thread.filter(|_| !self.is_resolve());
        let Some(count) = allowed.and_then(|suite| suite.num_cpus) else {
            return 0;
        };
        let mut threads = 0;
        // SAFETY: the host vouches for its function.
        let status = unsafe { count(&raw mut threads) };
        let here = std::thread::available_parallelism().map_or(1, |n| n.get() as u32);
        match status {
            0 if threads > 0 && threads < here => threads,
            _ => 0,
        }
    }
}
