//! Threads of the library's own, one pool for each limit, and work done on them while the caller waits.
//!
//! Callers wait on their own thread, on which alone they are called back. Work owns all it needs, so that a caller who
//! says stop is let go at once while what is under way comes to its end by itself. No thread outlives the last lens that
//! is held, or `seidel_shutdown`: code must not run in a library that is unloaded.

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::callbacks::SeidelCallbacks;
use crate::guard::{caught, guard};
use crate::handles;
use crate::status::{Failure, Result, SeidelStatus};

/// How often callers are called back.
const TURN: Duration = Duration::from_millis(20);

/// How long one who said stop waits for the work to end before it is left to itself.
const GRACE: Duration = Duration::from_millis(40);

struct Pool {
    rayon: ThreadPool,
    threads: Vec<JoinHandle<()>>,
}

static POOLS: Mutex<BTreeMap<usize, Pool>> = Mutex::new(BTreeMap::new());

/// Calls that wait for work.
static CALLS: AtomicUsize = AtomicUsize::new(0);

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // What is locked here is whole wherever a thread may have died.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Pool {
    fn new(count: usize) -> io::Result<Self> {
        let mut threads = Vec::with_capacity(count);
        let rayon = ThreadPoolBuilder::new()
            .num_threads(count)
            .spawn_handler(|thread| {
                let named = thread::Builder::new().name(format!("seidel-{}", thread.index()));
                threads.push(named.spawn(|| thread.run())?);
                Ok(())
            })
            .build();
        match rayon {
            Ok(rayon) => Ok(Self { rayon, threads }),
            Err(error) => {
                // The pool is gone: so will be those that came to be.
                threads.into_iter().for_each(wait_for);
                Err(io::Error::other(error))
            }
        }
    }

    /// Lets work that is under way end, then the threads.
    fn end(self) {
        drop(self.rayon);
        self.threads.into_iter().for_each(wait_for);
    }
}

fn wait_for(thread: JoinHandle<()>) {
    // How a thread of rayon ended tells nothing that its work has not told.
    let _ = thread.join();
}

/// Ends all threads of the library, when their work is done.
fn end_all() {
    let pools = std::mem::take(&mut *lock(&POOLS));
    pools.into_values().for_each(Pool::end);
}

/// Ends all threads if nobody is left who could give them work.
pub(crate) fn end_if_unused() {
    if CALLS.load(Ordering::SeqCst) == 0 && !handles::any() {
        end_all();
    }
}

/// A call that works, for as long as it is there.
struct Call;

impl Call {
    fn begin() -> Self {
        CALLS.fetch_add(1, Ordering::SeqCst);
        Self
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        CALLS.fetch_sub(1, Ordering::SeqCst);
        end_if_unused();
    }
}

/// What work tells while it goes on.
pub(crate) struct Watch {
    /// Bits of the share done.
    share: AtomicU64,
    stop: AtomicBool,
}

impl Watch {
    /// Tells that `share` is done; whether to go on.
    pub(crate) fn tell(&self, share: f64) -> bool {
        // Shares are not negative: their bits are ordered as they are.
        self.share
            .fetch_max(share.max(0.0).to_bits(), Ordering::Relaxed);
        !self.stop.load(Ordering::Relaxed)
    }

    fn share(&self) -> f64 {
        f64::from_bits(self.share.load(Ordering::Relaxed))
    }
}

/// Work under way: how far it is, and what came of it.
struct Underway<T> {
    watch: Watch,
    /// Nothing within: it panicked.
    outcome: Mutex<Option<Option<Result<T>>>>,
    ended: Condvar,
}

/// Does `work` on at most `limit` threads, all that the machine has if it is 0, while the caller is called back.
pub(crate) fn run<T: Send + 'static>(
    limit: u32,
    callbacks: &SeidelCallbacks,
    work: impl FnOnce(&Watch) -> Result<T> + Send + 'static,
) -> Result<T> {
    let _call = Call::begin();
    if !callbacks.tell(0.0) {
        return Err(Failure::aborted());
    }
    let underway = Arc::new(Underway {
        watch: Watch {
            share: AtomicU64::new(0),
            stop: AtomicBool::new(false),
        },
        outcome: Mutex::new(None),
        ended: Condvar::new(),
    });
    let own = Arc::clone(&underway);
    spawn(limit, move || {
        let outcome = caught(|| work(&own.watch));
        *lock(&own.outcome) = Some(outcome);
        own.ended.notify_all();
    })?;
    let outcome = wait(&underway, callbacks)?;
    callbacks.tell(1.0);
    outcome.unwrap_or_else(|| Err(Failure::panicked()))
}

/// Waits for the outcome; an error if the caller said stop.
fn wait<T>(underway: &Underway<T>, callbacks: &SeidelCallbacks) -> Result<Option<Result<T>>> {
    let mut stopped_at: Option<Instant> = None;
    let mut outcome = lock(&underway.outcome);
    loop {
        if let Some(outcome) = outcome.take() {
            return match stopped_at {
                Some(_) => Err(Failure::aborted()),
                None => Ok(outcome),
            };
        }
        if stopped_at.is_some_and(|at| at.elapsed() >= GRACE) {
            return Err(Failure::aborted());
        }
        let waited = underway.ended.wait_timeout(outcome, TURN);
        outcome = waited.unwrap_or_else(PoisonError::into_inner).0;
        if outcome.is_none() && stopped_at.is_none() {
            drop(outcome);
            if !callbacks.tell(underway.watch.share().min(1.0)) {
                underway.watch.stop.store(true, Ordering::Relaxed);
                stopped_at = Some(Instant::now());
            }
            outcome = lock(&underway.outcome);
        }
    }
}

fn spawn(limit: u32, work: impl FnOnce() + Send + 'static) -> Result<()> {
    let all = || thread::available_parallelism().map_or(1, |count| count.get());
    let count = match limit {
        0 => all(),
        limit => (limit as usize).min(MOST_THREADS),
    };
    let mut pools = lock(&POOLS);
    let pool = match pools.remove(&count) {
        Some(pool) => pool,
        None => Pool::new(count).map_err(|e| {
            Failure::new(
                SeidelStatus::Memory,
                format!("threads: could not start {count} ({e}); set fewer"),
            )
        })?,
    };
    pool.rayon.spawn(work);
    pools.insert(count, pool);
    Ok(())
}

/// Most threads of a pool.
const MOST_THREADS: usize = 1024;

/// Ends all threads of the library, after the work that they do. Call it before the library is unloaded; it is done by
/// itself when the last lens is released. The library can go on being used: threads are started again when there is work.
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
    use crate::pointers::Sized64;

    #[test]
    fn work_that_panics_is_told_and_the_pool_goes_on() {
        let none = SeidelCallbacks::neutral();
        let failed: Result<()> = run(2, &none, |_| panic!("planted"));
        assert_eq!(failed.map_err(|f| f.status), Err(SeidelStatus::Panicked));
        let sum = run(2, &none, |_| Ok((1..=10).sum::<u32>()));
        assert_eq!(sum, Ok(55));
    }

    unsafe extern "C" fn stop(_: *mut std::ffi::c_void, share: f64) -> i32 {
        i32::from(share > 0.0)
    }

    #[test]
    fn one_who_says_stop_is_let_go_though_work_does_not_listen() {
        let callbacks = SeidelCallbacks {
            progress: Some(stop),
            ..SeidelCallbacks::neutral()
        };
        // Somebody else who uses the library: the last one would wait for all threads to end.
        let _other = Call::begin();
        let (free, blocked) = std::sync::mpsc::channel::<()>();
        let ended = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&ended);
        let outcome = run(1, &callbacks, move |watch| {
            watch.tell(0.5);
            // Not before the caller was let go.
            let _ = blocked.recv();
            told.store(true, Ordering::SeqCst);
            Ok(())
        });
        assert_eq!(outcome.map_err(|f| f.status), Err(SeidelStatus::Aborted));
        assert!(!ended.load(Ordering::SeqCst));
        free.send(()).expect("still at work");
        assert_eq!(seidel_shutdown(), SeidelStatus::Ok);
        assert!(ended.load(Ordering::SeqCst), "shutdown waits for it");
    }
}
