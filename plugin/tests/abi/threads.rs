//! Progress, cancellation, calls from several threads, the end of the library's threads, and the memory limit.

use std::ffi::c_void;
use std::process::Command;
use std::ptr::{null, null_mut};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use seidel_c::*;

use crate::support::{
    LensHandle, TestImage, apply, assert_ok, assert_refused, exports, plate, settings,
};

const AREA: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: 160,
    height: 120,
};

/// Records the calls of a progress callback, and states its behaviour.
struct ProgressLog {
    shares: Vec<f64>,
    /// The thread on which the callback must be called.
    thread: std::thread::ThreadId,
    /// Number of calls after which the callback stops the work.
    stop_after: usize,
    /// Handle that the first call releases; NULL for none.
    release: *mut SeidelLens,
}

unsafe extern "C" fn record_progress(user: *mut c_void, share: f64) -> i32 {
    // SAFETY: `user` is the `ProgressLog` of the thread that waits for the call.
    let log = unsafe { &mut *user.cast::<ProgressLog>() };
    assert_eq!(log.thread, std::thread::current().id());
    log.shares.push(share);
    if !log.release.is_null() {
        // SAFETY: any value is safe as a handle.
        unsafe { (exports().release)(log.release) };
        log.release = null_mut();
    }
    i32::from(log.shares.len() > log.stop_after)
}

impl ProgressLog {
    fn new(stop_after: usize) -> Self {
        Self {
            shares: Vec::new(),
            thread: std::thread::current().id(),
            stop_after,
            release: null_mut(),
        }
    }

    fn callbacks(&mut self) -> SeidelCallbacks {
        SeidelCallbacks {
            size: size_of::<SeidelCallbacks>() as u64,
            user: std::ptr::from_mut(self).cast(),
            progress: Some(record_progress),
        }
    }
}

/// Returns settings that make a call slow: exact quality and large kernels.
fn slow_settings() -> SeidelSettings {
    let mut settings = settings();
    settings.quality = SEIDEL_QUALITY_EXACT;
    settings.amount = 4.0;
    settings.threads = 2;
    settings
}

#[test]
fn progress_grows_to_one_on_the_callers_thread() {
    let lens = LensHandle::new(3.0);
    let source = TestImage::pattern(AREA, 4);
    let image = source.input();
    let plate = plate(&image, AREA);
    let mut out = TestImage::black(AREA, 4);
    let output = out.output();
    let mut log = ProgressLog::new(usize::MAX);
    let callbacks = log.callbacks();
    // SAFETY: all pointers are valid.
    assert_ok(unsafe {
        (exports().apply)(
            lens.0,
            &slow_settings(),
            &plate,
            &output,
            null(),
            &callbacks,
        )
    });
    assert_eq!(
        (log.shares.first(), log.shares.last()),
        (Some(&0.0), Some(&1.0))
    );
    assert!(log.shares.is_sorted(), "{:?}", log.shares);
}

#[test]
fn a_stopped_call_writes_nothing() {
    let lens = LensHandle::new(3.0);
    let source = TestImage::pattern(AREA, 4);
    let image = source.input();
    let plate = plate(&image, AREA);
    for stop_after in [0, 1] {
        let mut out = TestImage::black(AREA, 4);
        let output = out.output();
        let mut log = ProgressLog::new(stop_after);
        let callbacks = log.callbacks();
        // SAFETY: all pointers are valid.
        unsafe {
            let status = (exports().apply)(
                lens.0,
                &slow_settings(),
                &plate,
                &output,
                null(),
                &callbacks,
            );
            assert_refused(status, SeidelStatus::Aborted, "stopped the call");
            let status = (exports().remove)(
                lens.0,
                &slow_settings(),
                &plate,
                &output,
                null(),
                null_mut(),
                &callbacks,
            );
            assert_refused(status, SeidelStatus::Aborted, "stopped the call");
            let relens = exports().relens;
            let status = relens(
                lens.0,
                lens.0,
                &slow_settings(),
                &plate,
                &output,
                null(),
                &callbacks,
            );
            assert_refused(status, SeidelStatus::Aborted, "stopped the call");
        }
        assert!(out.samples.iter().all(|v| *v == 0.0));
    }
    // The library remains usable.
    apply(&lens, &settings(), &plate, AREA);
}

#[test]
fn several_threads_share_a_lens() {
    let lens = LensHandle::new(2.0);
    let results = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for threads in [1, 2, 2, 3] {
            let (lens, results) = (&lens, &results);
            scope.spawn(move || {
                let source = TestImage::pattern(AREA, 4);
                let image = source.input();
                let mut settings = settings();
                settings.threads = threads;
                let bits = apply(lens, &settings, &plate(&image, AREA), AREA).bits();
                results.lock().expect("no panic").push(bits);
            });
        }
    });
    let results = results.into_inner().expect("no panic");
    assert!(results.len() == 4 && results.iter().all(|bits| *bits == results[0]));
}

#[test]
fn a_lens_that_is_released_in_use_lives_until_the_call_ends() {
    let lens = LensHandle::new(3.0);
    let source = TestImage::pattern(AREA, 4);
    let image = source.input();
    let plate = plate(&image, AREA);
    let want = apply(&lens, &slow_settings(), &plate, AREA);
    let mut out = TestImage::black(AREA, 4);
    let output = out.output();
    let mut log = ProgressLog::new(usize::MAX);
    log.release = lens.0;
    let callbacks = log.callbacks();
    // SAFETY: all pointers are valid; the handle is released within the call.
    assert_ok(unsafe {
        (exports().apply)(
            lens.0,
            &slow_settings(),
            &plate,
            &output,
            null(),
            &callbacks,
        )
    });
    assert!(log.release.is_null());
    assert_eq!(out.bits(), want.bits());
    // SAFETY: any value is safe as a handle.
    let again = unsafe { (exports().retain)(lens.0) };
    assert_refused(again, SeidelStatus::Argument, "not a handle");
}

/// Returns the number of threads of the library in this process; `None` on systems other than Linux.
fn library_threads() -> Option<usize> {
    // A `/proc` that a Windows program sees under Wine is not about its own process.
    if !cfg!(target_os = "linux") {
        return None;
    }
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let names = tasks.flatten().filter_map(|task| {
        let name = std::fs::read_to_string(task.path().join("comm")).ok()?;
        name.starts_with("seidel-").then_some(name)
    });
    Some(names.count())
}

/// Asserts that the library has `wanted` threads. A joined thread stands in `/proc` for a moment longer, and a started one
/// gets its name a moment later, so this waits.
fn assert_library_threads(wanted: usize) {
    let patience = Instant::now() + Duration::from_secs(10);
    while library_threads() != Some(wanted) && Instant::now() < patience {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(library_threads(), Some(wanted));
}

/// Environment variable that marks the process that a test started for itself.
const ALONE: &str = "SEIDEL_TEST_ALONE";

/// Runs in a process of its own, because other tests keep threads of the library alive.
#[test]
fn threads_end_with_the_last_lens_and_with_shutdown() {
    if std::env::var_os(ALONE).is_none() {
        let name = "threads::threads_end_with_the_last_lens_and_with_shutdown";
        let program = std::env::current_exe().expect("the path of the test");
        let output = Command::new(program)
            .args(["--exact", name, "--nocapture"])
            .env(ALONE, "1")
            .output()
            .expect("it runs");
        let stdout = String::from_utf8_lossy(&output.stdout);
        assert!(
            output.status.success() && stdout.contains("1 passed"),
            "{stdout}"
        );
        return;
    }
    let source = TestImage::pattern(AREA, 3);
    let image = source.input();
    let plate = plate(&image, AREA);
    let lens = LensHandle::new(2.0);
    let want = apply(&lens, &slow_settings(), &plate, AREA).bits();
    if library_threads().is_none() {
        return;
    }
    assert_library_threads(2);
    // SAFETY: the function has no requirements.
    assert_ok(unsafe { (exports().shutdown)() });
    assert_library_threads(0);
    // Work starts them again. They end with the last lens, even after a stopped call.
    assert_eq!(apply(&lens, &slow_settings(), &plate, AREA).bits(), want);
    let mut out = TestImage::black(AREA, 3);
    let output = out.output();
    let mut log = ProgressLog::new(1);
    let callbacks = log.callbacks();
    // SAFETY: all pointers are valid.
    let status = unsafe {
        (exports().apply)(
            lens.0,
            &slow_settings(),
            &plate,
            &output,
            null(),
            &callbacks,
        )
    };
    assert_refused(status, SeidelStatus::Aborted, "stopped the call");
    let second = LensHandle::new(2.0);
    drop(lens);
    assert_library_threads(2);
    drop(second);
    assert_library_threads(0);
}

#[test]
fn the_memory_limit_is_compared_with_the_memory_needed() {
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(AREA, 4);
    let image = source.input();
    let plate = plate(&image, AREA);
    let mut settings = settings();
    let mut out = TestImage::black(AREA, 4);
    let output = out.output();
    for removal in [0, 1] {
        let mut needed = 0;
        // SAFETY: all pointers are valid.
        unsafe {
            assert_ok((exports().memory)(&settings, &plate, removal, &mut needed));
            assert!(needed >= 160 * 120 * 4 * 16, "{needed}");
            let mut call = |memory: u64| {
                settings.memory = memory;
                match removal {
                    0 => (exports().apply)(lens.0, &settings, &plate, &output, null(), null()),
                    _ => (exports().remove)(
                        lens.0,
                        &settings,
                        &plate,
                        &output,
                        null(),
                        null_mut(),
                        null(),
                    ),
                }
            };
            assert_refused(call(needed - 1), SeidelStatus::Memory, "settings.memory");
            assert_ok(call(needed));
        }
    }
}
