//! The multi-thread suite, on real threads or, in serial hosts, on the calling one.

use std::cell::Cell;
use std::ffi::{c_int, c_uint, c_void};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::ThreadId;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::multi_thread::*;

use super::pointers::{with_host, with_object, write_result};
use crate::host::action::{current_action, within_action};
use crate::host::{Host, Object, locked};

/// The most threads that a plugin gets, whatever it asks for.
const MAX_THREADS: c_uint = 64;

pub(super) fn suite() -> OfxMultiThreadSuiteV1 {
    OfxMultiThreadSuiteV1 {
        multiThread: Some(multi_thread),
        multiThreadNumCPUs: Some(num_cpus),
        multiThreadIndex: Some(index),
        multiThreadIsSpawnedThread: Some(is_spawned),
        mutexCreate: Some(create),
        mutexDestroy: Some(destroy),
        mutexLock: Some(lock),
        mutexUnLock: Some(unlock),
        mutexTryLock: Some(try_lock),
    }
}

thread_local! {
    /// The index of a thread of this suite.
    static INDEX: Cell<Option<c_uint>> = const { Cell::new(None) };
}

/// A function of the plugin with its argument.
#[derive(Clone, Copy)]
struct Work {
    function: unsafe extern "C" fn(c_uint, c_uint, *mut c_void),
    argument: *mut c_void,
}

// SAFETY: the plugin passes it to be run on several threads.
unsafe impl Send for Work {}
// SAFETY: as above.
unsafe impl Sync for Work {}

impl Work {
    fn run(&self, index: c_uint, count: c_uint) {
        let outer = INDEX.replace(Some(index));
        // SAFETY: the plugin passed function and argument together.
        unsafe { (self.function)(index, count, self.argument) };
        INDEX.set(outer);
    }
}

fn processors(host: &Host) -> c_uint {
    c_uint::try_from(host.processors.load(Ordering::SeqCst)).unwrap_or(1)
}

unsafe extern "C" fn multi_thread(
    function: OfxThreadFunctionV1,
    count: c_uint,
    argument: *mut c_void,
) -> OfxStatus {
    with_host(|host| {
        let Some(function) = function else {
            return kOfxStatFailed;
        };
        if INDEX.get().is_some() {
            return kOfxStatErrExists;
        }
        if host.threads_fail.load(Ordering::SeqCst) {
            return kOfxStatFailed;
        }
        let count = if count == 0 {
            processors(host).max(1)
        } else {
            count.min(MAX_THREADS)
        };
        let work = Work { function, argument };
        if host.profile.serial_threads {
            for index in 0..count {
                work.run(index, count);
            }
            return kOfxStatOK;
        }
        let action = current_action();
        std::thread::scope(|scope| {
            // The last index starts first, because plugins must not depend on the order.
            for index in (0..count).rev() {
                let action = action.clone();
                scope.spawn(move || within_action(action, || work.run(index, count)));
            }
        });
        kOfxStatOK
    })
}

unsafe extern "C" fn num_cpus(count: *mut c_uint) -> OfxStatus {
    with_host(|host| {
        if host.threads_fail.load(Ordering::SeqCst) {
            return kOfxStatFailed;
        }
        // SAFETY: the plugin provides memory for a number.
        unsafe { write_result(count, processors(host), "multiThreadNumCPUs") }
    })
}

unsafe extern "C" fn index(index: *mut c_uint) -> OfxStatus {
    // SAFETY: the plugin provides memory for a number.
    unsafe { write_result(index, INDEX.get().unwrap_or(0), "multiThreadIndex") }
}

unsafe extern "C" fn is_spawned() -> c_int {
    c_int::from(INDEX.get().is_some())
}

/// A mutex that its owner may lock again.
#[derive(Default)]
pub(crate) struct RecursiveMutex {
    state: Mutex<LockState>,
    released: Condvar,
}

#[derive(Default)]
struct LockState {
    owner: Option<ThreadId>,
    count: usize,
}

impl RecursiveMutex {
    fn lock(&self) {
        let current = std::thread::current().id();
        let mut state = locked(&self.state);
        while state.owner.is_some_and(|owner| owner != current) {
            state = self
                .released
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
        state.acquire(current);
    }

    /// Returns false if another thread owns it.
    fn try_lock(&self) -> bool {
        let current = std::thread::current().id();
        let mut state = locked(&self.state);
        let is_free = state.owner.is_none_or(|owner| owner == current);
        if is_free {
            state.acquire(current);
        }
        is_free
    }

    /// Returns false if this thread does not own it.
    fn unlock(&self) -> bool {
        let mut state = locked(&self.state);
        if state.owner != Some(std::thread::current().id()) {
            return false;
        }
        state.count -= 1;
        if state.count == 0 {
            state.owner = None;
            self.released.notify_one();
        }
        true
    }
}

impl LockState {
    fn acquire(&mut self, owner: ThreadId) {
        self.owner = Some(owner);
        self.count += 1;
    }
}

unsafe extern "C" fn create(mutex: *mut OfxMutexHandle, lock_count: c_int) -> OfxStatus {
    with_host(|host| {
        let created = Arc::new(RecursiveMutex::default());
        for _ in 0..lock_count {
            created.lock();
        }
        let handle = host.register("a mutex", Object::Mutex(created));
        host.counters.mutexes_held.fetch_add(1, Ordering::SeqCst);
        // SAFETY: the plugin provides memory for a handle.
        unsafe { write_result(mutex, handle as *mut _, "mutexCreate") }
    })
}

unsafe extern "C" fn destroy(mutex: OfxMutexHandle) -> OfxStatus {
    with_object::<RecursiveMutex>(mutex as usize, "mutexDestroy", |host, _| {
        host.invalidate(mutex as usize);
        host.counters.mutexes_held.fetch_sub(1, Ordering::SeqCst);
        kOfxStatOK
    })
}

unsafe extern "C" fn lock(mutex: OfxMutexHandle) -> OfxStatus {
    with_object::<RecursiveMutex>(mutex as usize, "mutexLock", |_, mutex| {
        mutex.lock();
        kOfxStatOK
    })
}

unsafe extern "C" fn unlock(mutex: OfxMutexHandle) -> OfxStatus {
    with_object::<RecursiveMutex>(mutex as usize, "mutexUnLock", |host, mutex| {
        if mutex.unlock() {
            return kOfxStatOK;
        }
        host.record_misuse("mutexUnLock was called on a thread that does not own the mutex");
        kOfxStatFailed
    })
}

unsafe extern "C" fn try_lock(mutex: OfxMutexHandle) -> OfxStatus {
    with_object::<RecursiveMutex>(mutex as usize, "mutexTryLock", |_, mutex| {
        if mutex.try_lock() {
            kOfxStatOK
        } else {
            kOfxStatFailed
        }
    })
}
