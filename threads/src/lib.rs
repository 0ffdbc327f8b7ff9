//! Thread pools for libraries that hosts load, cancel and unload.
//!
//! The global pool of rayon lives until the process ends, and code must not run in a library that was unloaded. The pools
//! of a [`Threads`] end on request. The caller of [`Threads::run`] waits on its own thread, which alone calls the host.
#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};

/// Time between two calls of the host.
const POLL_INTERVAL: Duration = Duration::from_millis(10);

/// Time that a cancelled call waits for its work to end before it leaves the work to itself. With one interval it stays below
/// the 50 ms that docs/guide/hosts.md aims at, and the 100 ms that the header of the C ABI promises.
const GRACE_PERIOD: Duration = Duration::from_millis(15);

/// Largest number of threads of a pool.
const MAX_THREADS: usize = 1024;

/// Thread pools, one for each limit on the number of threads.
pub struct Threads {
    pools: Mutex<BTreeMap<usize, Pool>>,
    /// Number of calls of [`Threads::run`] under way.
    calls: AtomicUsize,
}

/// Why work has no result.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The caller cancelled it.
    #[error("cancelled on request")]
    Cancelled,
    /// The threads of the pool could not be started.
    #[error("could not start {count} threads ({source})")]
    Start {
        /// Number of threads of the pool.
        count: usize,
        /// The error of the operating system.
        source: io::Error,
    },
}

impl Threads {
    /// Creates an empty set of pools.
    pub const fn new() -> Self {
        Self {
            pools: Mutex::new(BTreeMap::new()),
            calls: AtomicUsize::new(0),
        }
    }

    /// Runs `work` on at most `limit` threads, or on all that the machine has if `limit` is 0, and returns its result.
    ///
    /// Meanwhile `report` is called on the calling thread with the share done, 0 to 1: at the start, about fifty times a
    /// second, and at the end. `work` is cancelled when it returns `false`. `work` gets a function to report progress
    /// with, which returns `false` once it should stop. It owns its data, so that a cancelled caller need not wait until
    /// it does.
    ///
    /// # Errors
    /// Cancellation by `report`, and threads that cannot be started.
    ///
    /// # Panics
    /// With the panic of `work`. The pool remains usable.
    pub fn run<T: Send + 'static>(
        &self,
        limit: u32,
        report: impl Fn(f64) -> bool,
        work: impl FnOnce(&(dyn Fn(f64) -> bool + Sync)) -> T + Send + 'static,
    ) -> Result<T, RunError> {
        let _call = CallCount::new(&self.calls);
        if !report(0.0) {
            return Err(RunError::Cancelled);
        }
        let job = Arc::new(Job {
            share_bits: AtomicU64::new(0),
            is_cancelled: AtomicBool::new(false),
            outcome: Mutex::new(None),
            ended: Condvar::new(),
        });
        let own = Arc::clone(&job);
        self.spawn(limit, move || {
            let outcome = catch_unwind(AssertUnwindSafe(|| work(&|share| own.progress(share))));
            *lock(&own.outcome) = Some(outcome);
            own.ended.notify_all();
        })?;
        let outcome = job.wait(&report)?;
        report(1.0);
        Ok(outcome.unwrap_or_else(|panic| resume_unwind(panic)))
    }

    /// Waits for all work and ends all threads. Later calls of [`Threads::run`] start new ones.
    pub fn end(&self) {
        let pools = std::mem::take(&mut *lock(&self.pools));
        pools.into_values().for_each(Pool::end);
    }

    /// Ends all threads as [`Threads::end`], unless a call is under way.
    pub fn end_if_idle(&self) {
        if self.calls.load(Ordering::SeqCst) == 0 {
            self.end();
        }
    }

    fn spawn(&self, limit: u32, work: impl FnOnce() + Send + 'static) -> Result<(), RunError> {
        let count = match limit {
            0 => thread::available_parallelism().map_or(1, usize::from),
            limit => (limit as usize).min(MAX_THREADS),
        };
        let mut pools = lock(&self.pools);
        let pool = match pools.remove(&count) {
            Some(pool) => pool,
            None => Pool::start(count).map_err(|source| RunError::Start { count, source })?,
        };
        pool.rayon.spawn(work);
        pools.insert(count, pool);
        Ok(())
    }
}

impl Default for Threads {
    fn default() -> Self {
        Self::new()
    }
}

/// Counts a call for as long as it lives.
struct CallCount<'a>(&'a AtomicUsize);

impl<'a> CallCount<'a> {
    fn new(calls: &'a AtomicUsize) -> Self {
        calls.fetch_add(1, Ordering::SeqCst);
        Self(calls)
    }
}

impl Drop for CallCount<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// A pool whose threads can be joined.
struct Pool {
    rayon: ThreadPool,
    threads: Vec<JoinHandle<()>>,
}

impl Pool {
    fn start(count: usize) -> io::Result<Self> {
        let mut threads = Vec::with_capacity(count);
        let rayon = ThreadPoolBuilder::new()
            .num_threads(count)
            .spawn_handler(|thread| {
                let builder = thread::Builder::new().name(format!("seidel-{}", thread.index()));
                threads.push(builder.spawn(|| thread.run())?);
                Ok(())
            })
            .build();
        match rayon {
            Ok(rayon) => Ok(Self { rayon, threads }),
            Err(error) => {
                // The threads that were started end by themselves, since their pool is gone.
                threads.into_iter().for_each(join);
                Err(io::Error::other(error))
            }
        }
    }

    fn end(self) {
        drop(self.rayon);
        self.threads.into_iter().for_each(join);
    }
}

fn join(thread: JoinHandle<()>) {
    // The outcome of the work was delivered by its job.
    let _ = thread.join();
}

/// Work under way.
struct Job<T> {
    /// Bits of the share done. Shares are not negative, so their bits have the same order.
    share_bits: AtomicU64,
    is_cancelled: AtomicBool,
    outcome: Mutex<Option<thread::Result<T>>>,
    ended: Condvar,
}

impl<T> Job<T> {
    /// Records that `share` is done; returns whether to go on.
    fn progress(&self, share: f64) -> bool {
        self.share_bits
            .fetch_max(share.max(0.0).to_bits(), Ordering::Relaxed);
        !self.is_cancelled.load(Ordering::Relaxed)
    }

    /// Waits for the outcome and calls `report` meanwhile.
    fn wait(&self, report: impl Fn(f64) -> bool) -> Result<thread::Result<T>, RunError> {
        let mut cancelled_at: Option<Instant> = None;
        let mut outcome = lock(&self.outcome);
        loop {
            if let Some(outcome) = outcome.take() {
                return match cancelled_at {
                    Some(_) => Err(RunError::Cancelled),
                    None => Ok(outcome),
                };
            }
            if cancelled_at.is_some_and(|at| at.elapsed() >= GRACE_PERIOD) {
                return Err(RunError::Cancelled);
            }
            let waited = self.ended.wait_timeout(outcome, POLL_INTERVAL);
            outcome = waited.unwrap_or_else(PoisonError::into_inner).0;
            if outcome.is_none() && cancelled_at.is_none() {
                // Not under the lock: a host may take its time.
                drop(outcome);
                let share = f64::from_bits(self.share_bits.load(Ordering::Relaxed));
                if !report(share.min(1.0)) {
                    self.is_cancelled.store(true, Ordering::Relaxed);
                    cancelled_at = Some(Instant::now());
                }
                outcome = lock(&self.outcome);
            }
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // A poisoned lock is still valid: the locked value is never left half changed by a panic.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn a_panic_reaches_the_caller_and_the_pool_stays_usable() {
        let threads = Threads::new();
        let panicking = || threads.run(2, |_| true, |_| -> u32 { panic!("planted") });
        assert!(catch_unwind(AssertUnwindSafe(panicking)).is_err());
        let sum = threads.run(2, |_| true, |_| (1..=10).sum::<u32>());
        assert_eq!(sum.ok(), Some(55));
        threads.end_if_idle();
    }

    #[test]
    fn a_cancelled_caller_does_not_wait_for_work_that_ignores_it() {
        let threads = Threads::new();
        let (release, blocked) = mpsc::channel::<()>();
        let has_ended = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&has_ended);
        let outcome = threads.run(
            1,
            |share| share == 0.0,
            move |progress| {
                progress(0.5);
                // Until the caller has returned.
                let _ = blocked.recv();
                flag.store(true, Ordering::SeqCst);
            },
        );
        assert!(matches!(outcome, Err(RunError::Cancelled)));
        assert!(!has_ended.load(Ordering::SeqCst));
        release.send(()).expect("the work still runs");
        threads.end();
        assert!(has_ended.load(Ordering::SeqCst), "end waits for the work");
    }

    #[test]
    fn work_is_asked_to_stop_and_progress_is_reported() {
        let threads = Threads::new();
        let reported = Mutex::new(Vec::new());
        let report = |share: f64| {
            lock(&reported).push(share);
            share < 0.5
        };
        let outcome = threads.run(1, report, |progress| while progress(0.75) {});
        assert!(matches!(outcome, Err(RunError::Cancelled)));
        let reported = lock(&reported);
        assert_eq!((reported[0], reported.last()), (0.0, Some(&0.75)));
    }
}
