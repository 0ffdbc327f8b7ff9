//! The multi-thread suite: real threads, or one where the host is of that kind.

use std::cell::Cell;
use std::ffi::{c_int, c_uint, c_void};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Condvar, Mutex};
use std::thread::ThreadId;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::multi_thread::*;

use super::pointers::{found, put};
use crate::host::{Object, current, locked, under};

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
    static INDEX: Cell<Option<c_uint>> = const { Cell::new(None) };
}

/// What a plugin gives to be run on several threads.
#[derive(Clone, Copy)]
struct Work {
    function: unsafe extern "C" fn(c_uint, c_uint, *mut c_void),
    argument: *mut c_void,
}

// SAFETY: to be run on several threads is what the plugin gave it for.
unsafe impl Send for Work {}
// SAFETY: as above.
unsafe impl Sync for Work {}

impl Work {
    fn run(&self, index: c_uint, count: c_uint) {
        let before = INDEX.replace(Some(index));
        // SAFETY: function and argument belong together, by the plugin's word.
        unsafe { (self.function)(index, count, self.argument) };
        INDEX.set(before);
    }
}

unsafe extern "C" fn multi_thread(
    function: OfxThreadFunctionV1,
    count: c_uint,
    argument: *mut c_void,
) -> OfxStatus {
    let (Some(host), Some(function)) = (current(), function) else {
        return kOfxStatFailed;
    };
    if INDEX.get().is_some() {
        return kOfxStatErrExists;
    }
    if host.threads_fail.load(Ordering::SeqCst) {
        return kOfxStatFailed;
    }
    let most = c_uint::try_from(host.processors.load(Ordering::SeqCst))
        .unwrap_or(1)
        .max(1);
    let count = if count == 0 { most } else { count.min(64) };
    let work = Work { function, argument };
    if host.profile.serial {
        for index in 0..count {
            work.run(index, count);
        }
        return kOfxStatOK;
    }
    let doing = under::now();
    std::thread::scope(|scope| {
        // The last first: nothing may depend on the order.
        for index in (0..count).rev() {
            let doing = doing.clone();
            scope.spawn(move || under::doing(doing, || work.run(index, count)));
        }
    });
    kOfxStatOK
}

unsafe extern "C" fn num_cpus(count: *mut c_uint) -> OfxStatus {
    let Some(host) = current() else {
        return kOfxStatFailed;
    };
    if host.threads_fail.load(Ordering::SeqCst) {
        return kOfxStatFailed;
    }
    let processors = c_uint::try_from(host.processors.load(Ordering::SeqCst)).unwrap_or(1);
    // SAFETY: the plugin gives room for a number.
    unsafe { put(count, processors, "multiThreadNumCPUs") }
}

unsafe extern "C" fn index(at: *mut c_uint) -> OfxStatus {
    // SAFETY: the plugin gives room for a number.
    unsafe { put(at, INDEX.get().unwrap_or(0), "multiThreadIndex") }
}

unsafe extern "C" fn is_spawned() -> c_int {
    c_int::from(INDEX.get().is_some())
}

/// A mutex that its thread may lock again.
#[derive(Default)]
pub(crate) struct Lock {
    state: Mutex<(Option<ThreadId>, usize)>,
    free: Condvar,
}

impl Lock {
    fn take(&self, waits: bool) -> bool {
        let me = std::thread::current().id();
        let mut state = locked(&self.state);
        while state.0.is_some_and(|owner| owner != me) {
            if !waits {
                return false;
            }
            state = self
                .free
                .wait(state)
                .unwrap_or_else(std::sync::PoisonError::into_inner);
        }
        state.0 = Some(me);
        state.1 += 1;
        true
    }

    fn give(&self) -> bool {
        let mut state = locked(&self.state);
        if state.0 != Some(std::thread::current().id()) {
            return false;
        }
        state.1 -= 1;
        if state.1 == 0 {
            state.0 = None;
            self.free.notify_one();
        }
        true
    }
}

unsafe extern "C" fn create(mutex: *mut OfxMutexHandle, count: c_int) -> OfxStatus {
    let Some(host) = current() else {
        return kOfxStatFailed;
    };
    let made = Arc::new(Lock::default());
    for _ in 0..count.max(0) {
        made.take(true);
    }
    let handle = host.keep("a mutex", Object::Lock(made));
    host.counts.mutexes_out.fetch_add(1, Ordering::SeqCst);
    // SAFETY: the plugin gives room for a handle.
    unsafe { put(mutex, handle as *mut _, "mutexCreate") }
}

unsafe extern "C" fn destroy(mutex: OfxMutexHandle) -> OfxStatus {
    match found::<Lock>(mutex as usize, "mutexDestroy") {
        Ok((host, _)) => {
            host.end(mutex as usize);
            host.counts.mutexes_out.fetch_sub(1, Ordering::SeqCst);
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn lock(mutex: OfxMutexHandle) -> OfxStatus {
    match found::<Lock>(mutex as usize, "mutexLock") {
        Ok((_, mutex)) => {
            mutex.take(true);
            kOfxStatOK
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn unlock(mutex: OfxMutexHandle) -> OfxStatus {
    match found::<Lock>(mutex as usize, "mutexUnLock") {
        Ok((_, mutex)) if mutex.give() => kOfxStatOK,
        Ok((host, _)) => {
            host.misused("mutexUnLock was called by a thread that has not locked it".to_owned());
            kOfxStatFailed
        }
        Err(status) => status,
    }
}

unsafe extern "C" fn try_lock(mutex: OfxMutexHandle) -> OfxStatus {
    match found::<Lock>(mutex as usize, "mutexTryLock") {
        Ok((_, mutex)) if mutex.take(false) => kOfxStatOK,
        Ok(_) => kOfxStatFailed,
        Err(status) => status,
    }
}
