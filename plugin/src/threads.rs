//! The library's own threads: one pool for each thread limit, and work done on them while the caller waits.
//!
//! The caller waits on its own thread, and its callback is called there. Work owns all its data, so that a caller who
//! stops it can return at once while the work ends in the background. No thread outlives the last lens handle or
//! `seidel_shutdown`, because its code must not run after the library was unloaded.

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::callbacks::SeidelCallbacks;
use crate::guard::{catch_panic, guard};
use crate::handles;
use crate::status::{Failure, Result, SeidelStatus};

/// Time between two calls of the progress callback.
const CALLBACK_INTERVAL: Duration = Duration::from_millis(20);

/// Time for stopped work to end before the caller returns without it. With one callback interval it stays below the
/// 100 ms that the header promises.
const STOP_TIMEOUT: Duration = Duration::from_millis(40);

/// Most threads of a pool; larger limits count as this one.
const MAX_THREADS: usize = 1024;

/// A thread pool whose threads can be joined.
struct Pool {
    rayon: ThreadPool,
    threads: Vec<JoinHandle<()>>,
}

/// Pools by number of threads.
static POOLS: Mutex<BTreeMap<usize, Pool>> = Mutex::new(BTreeMap::new());

/// Number of calls that wait for work.
static ACTIVE_CALLS: AtomicUsize = AtomicUsize::new(0);

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // The data of these locks are consistent at every point where a thread can panic.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Pool {
    fn new(count: usize) -> io::Result<Self> {
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
                // Without a pool, the threads that were started end by themselves.
                threads.into_iter().for_each(join);
                Err(io::Error::other(error))
            }
        }
    }

    /// Waits until work under way and then the threads have ended.
    fn end(self) {
        drop(self.rayon);
        self.threads.into_iter().for_each(join);
    }
}

fn join(thread: JoinHandle<()>) {
    // Panics of work are caught and reported in `run`.
    let _ = thread.join();
}

/// Ends all threads of the library after their work.
fn end_all() {
    let pools = std::mem::take(&mut *lock(&POOLS));
    pools.into_values().for_each(Pool::end);
}

/// Ends all threads if there is neither a call nor a lens handle.
pub(crate) fn end_if_unused() {
    if ACTIVE_CALLS.load(Ordering::SeqCst) == 0 && !handles::any() {
        end_all();
    }
}

/// Counts a call as active while it exists.
struct ActiveCall;

impl ActiveCall {
    fn begin() -> Self {
        ACTIVE_CALLS.fetch_add(1, Ordering::SeqCst);
        Self
    }
}

impl Drop for ActiveCall {
    fn drop(&mut self) {
        ACTIVE_CALLS.fetch_sub(1, Ordering::SeqCst);
        end_if_unused();
    }
}

/// Progress and stop flag of a call, shared by the work and the waiting caller.
#[derive(Default)]
pub(crate) struct SharedProgress {
    /// The share done, as the bits of an `f64`.
    share: AtomicU64,
    stop: AtomicBool,
}

impl SharedProgress {
    /// Reports the share done; returns whether to go on.
    pub(crate) fn report(&self, share: f64) -> bool {
        // The bits of numbers that are not negative have the order of the numbers.
        self.share
            .fetch_max(share.max(0.0).to_bits(), Ordering::Relaxed);
        !self.stop.load(Ordering::Relaxed)
    }

    fn share(&self) -> f64 {
        f64::from_bits(self.share.load(Ordering::Relaxed))
    }
}

/// Work under way and its result.
struct Job<T> {
    progress: SharedProgress,
    result: Mutex<Option<Result<T>>>,
    ended: Condvar,
}

/// Does `work` on at most `limit` threads, or one for each core if it is 0, and calls the caller back meanwhile.
pub(crate) fn run<T: Send + 'static>(
    limit: u32,
    callbacks: &SeidelCallbacks,
    work: impl FnOnce(&SharedProgress) -> Result<T> + Send + 'static,
) -> Result<T> {
    let _call = ActiveCall::begin();
    if !callbacks.report(0.0) {
        return Err(Failure::aborted());
    }
    let job = Arc::new(Job {
        progress: SharedProgress::default(),
        result: Mutex::new(None),
        ended: Condvar::new(),
    });
    let own = Arc::clone(&job);
    spawn(limit, move || {
        let result = catch_panic(|| work(&own.progress));
        *lock(&own.result) = Some(result.unwrap_or_else(|| Err(Failure::panicked())));
        own.ended.notify_all();
    })?;
    let result = wait(&job, callbacks).ok_or_else(Failure::aborted)?;
    callbacks.report(1.0);
    result
}

/// Waits for the result of a job; returns `None` if the caller stopped it.
fn wait<T>(job: &Job<T>, callbacks: &SeidelCallbacks) -> Option<Result<T>> {
    let mut stopped_at: Option<Instant> = None;
    let mut result = lock(&job.result);
    loop {
        if let Some(result) = result.take() {
            return stopped_at.is_none().then_some(result);
        }
        if stopped_at.is_some_and(|at| at.elapsed() >= STOP_TIMEOUT) {
            return None;
        }
        let waited = job.ended.wait_timeout(result, CALLBACK_INTERVAL);
        result = waited.unwrap_or_else(PoisonError::into_inner).0;
        if result.is_none() && stopped_at.is_none() {
            // Work must be able to end while the callback runs.
            drop(result);
            if !callbacks.report(job.progress.share().min(1.0)) {
                job.progress.stop.store(true, Ordering::Relaxed);
                stopped_at = Some(Instant::now());
            }
            result = lock(&job.result);
        }
    }
}

/// Starts `work` on the pool of a thread limit, which is created on first use.
fn spawn(limit: u32, work: impl FnOnce() + Send + 'static) -> Result<()> {
    let count = match limit {
        0 => thread::available_parallelism().map_or(1, |count| count.get()),
        limit => (limit as usize).min(MAX_THREADS),
    };
    let mut pools = lock(&POOLS);
    let pool = match pools.remove(&count) {
        Some(pool) => pool,
        None => Pool::new(count).map_err(|e| {
            Failure::new(
                SeidelStatus::Memory,
                format!("settings.threads: could not start {count} ({e}); set a lower limit"),
            )
        })?,
    };
    pool.rayon.spawn(work);
    pools.insert(count, pool);
    Ok(())
}

/// Ends all threads of the library and waits for the work that they are doing. Call it before the library is
/// unloaded. It also happens when the last lens is released. The library remains usable: the next call starts threads
/// again.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_shutdown() -> SeidelStatus {
    guard(|| {
        end_all();
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pointers::Versioned;

    #[test]
    fn panics_of_work_are_reported_and_the_pool_goes_on() {
        let none = SeidelCallbacks::DEFAULT;
        let failed: Result<()> = run(2, &none, |_| panic!("planted"));
        assert_eq!(failed.map_err(|f| f.status), Err(SeidelStatus::Panicked));
        let sum = run(2, &none, |_| Ok((1..=10).sum::<u32>()));
        assert_eq!(sum, Ok(55));
    }

    unsafe extern "C" fn stop(_: *mut std::ffi::c_void, share: f64) -> i32 {
        i32::from(share > 0.0)
    }

    #[test]
    fn a_stopped_call_returns_although_its_work_goes_on() {
        let callbacks = SeidelCallbacks {
            progress: Some(stop),
            ..SeidelCallbacks::DEFAULT
        };
        // The end of the last call would wait for all threads; this one keeps them alive.
        let _other = ActiveCall::begin();
        let (release, blocked) = std::sync::mpsc::channel::<()>();
        let has_ended = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&has_ended);
        let outcome = run(1, &callbacks, move |progress| {
            progress.report(0.5);
            // Blocks until the call has returned.
            let _ = blocked.recv();
            flag.store(true, Ordering::SeqCst);
            Ok(())
        });
        assert_eq!(outcome.map_err(|f| f.status), Err(SeidelStatus::Aborted));
        assert!(!has_ended.load(Ordering::SeqCst));
        release.send(()).expect("work under way");
        assert_eq!(seidel_shutdown(), SeidelStatus::Ok);
        assert!(has_ended.load(Ordering::SeqCst), "shutdown waits for it");
    }
}
