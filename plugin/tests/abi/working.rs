//! Calls at work: told of, stopped, several at once, lenses released meanwhile, threads that end.

use std::ffi::c_void;
use std::process::Command;
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use seidel_c::*;

use crate::support::{Held, Picture, applied, doors, plate, refused, settings, well};

const AREA: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: 160,
    height: 120,
};

/// What a callback was told, and what it is to do.
struct Told {
    shares: Vec<f64>,
    thread: std::thread::ThreadId,
    /// After how many words to say stop.
    stop_after: usize,
    /// Released with the first word.
    release: *mut SeidelLens,
}

unsafe extern "C" fn told(user: *mut c_void, share: f64) -> i32 {
    // SAFETY: it is a `Told` of the thread that waits for the call.
    let told = unsafe { &mut *user.cast::<Told>() };
    assert_eq!(told.thread, std::thread::current().id());
    told.shares.push(share);
    if !told.release.is_null() {
        // SAFETY: a handle may be anything.
        unsafe { (doors().release)(told.release) };
        told.release = null_mut();
    }
    i32::from(told.shares.len() > told.stop_after)
}

impl Told {
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
            progress: Some(told),
        }
    }
}

/// Exact, so that it takes a while.
fn slow() -> SeidelSettings {
    let mut settings = settings();
    settings.quality = SEIDEL_QUALITY_EXACT;
    settings.amount = 4.0;
    settings.threads = 2;
    settings
}

#[test]
fn progress_grows_to_one_on_the_callers_thread() {
    let lens = Held::new(3.0);
    let source = Picture::busy(AREA, 4);
    let image = source.image();
    let plate = plate(&image, AREA);
    let mut out = Picture::black(AREA, 4);
    let output = out.output();
    let mut told = Told::new(usize::MAX);
    let callbacks = told.callbacks();
    // SAFETY: all pointers are good.
    well(unsafe { (doors().apply)(lens.0, &slow(), &plate, &output, null(), &callbacks) });
    assert_eq!(
        (told.shares.first(), told.shares.last()),
        (Some(&0.0), Some(&1.0))
    );
    assert!(told.shares.is_sorted(), "{:?}", told.shares);
}

#[test]
fn one_who_says_stop_gets_no_picture() {
    let lens = Held::new(3.0);
    let source = Picture::busy(AREA, 4);
    let image = source.image();
    let plate = plate(&image, AREA);
    for stop_after in [0, 1] {
        let mut out = Picture::black(AREA, 4);
        let output = out.output();
        let mut told = Told::new(stop_after);
        let callbacks = told.callbacks();
        // SAFETY: all pointers are good.
        unsafe {
            let status = (doors().apply)(lens.0, &slow(), &plate, &output, null(), &callbacks);
            refused(status, SeidelStatus::Aborted, "said to stop");
            let status = (doors().remove)(
                lens.0,
                &slow(),
                &plate,
                &output,
                null(),
                null_mut(),
                &callbacks,
            );
            refused(status, SeidelStatus::Aborted, "said to stop");
            let relens = doors().relens;
            let status = relens(lens.0, lens.0, &slow(), &plate, &output, null(), &callbacks);
            refused(status, SeidelStatus::Aborted, "said to stop");
        }
        assert!(out.samples.iter().all(|v| *v == 0.0));
    }
    // The library goes on.
    applied(&lens, &settings(), &plate, AREA);
}

#[test]
fn several_threads_share_a_lens() {
    let lens = Held::new(2.0);
    let results = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for threads in [1, 2, 2, 3] {
            let (lens, results) = (&lens, &results);
            scope.spawn(move || {
                let source = Picture::busy(AREA, 4);
                let image = source.image();
                let mut settings = settings();
                settings.threads = threads;
                let bits = applied(lens, &settings, &plate(&image, AREA), AREA).bits();
                results.lock().expect("no panic").push(bits);
            });
        }
    });
    let results = results.into_inner().expect("no panic");
    assert!(results.len() == 4 && results.iter().all(|bits| *bits == results[0]));
}

#[test]
fn a_lens_released_while_it_is_used_lives_until_the_call_ends() {
    let lens = Held::new(3.0);
    let source = Picture::busy(AREA, 4);
    let image = source.image();
    let plate = plate(&image, AREA);
    let want = applied(&lens, &slow(), &plate, AREA);
    let mut out = Picture::black(AREA, 4);
    let output = out.output();
    let mut told = Told::new(usize::MAX);
    told.release = lens.0;
    let callbacks = told.callbacks();
    // SAFETY: all pointers are good; the handle is released within the call.
    well(unsafe { (doors().apply)(lens.0, &slow(), &plate, &output, null(), &callbacks) });
    assert!(told.release.is_null());
    assert_eq!(out.bits(), want.bits());
    // SAFETY: a handle may be anything.
    let again = unsafe { (doors().retain)(lens.0) };
    refused(again, SeidelStatus::Argument, "not a handle");
}

/// Names of this process's threads that are the library's; nothing where they cannot be told.
fn library_threads() -> Option<usize> {
    let tasks = std::fs::read_dir("/proc/self/task").ok()?;
    let names = tasks.flatten().filter_map(|task| {
        let name = std::fs::read_to_string(task.path().join("comm")).ok()?;
        name.starts_with("seidel-").then_some(name)
    });
    Some(names.count())
}

const ALONE: &str = "SEIDEL_TEST_ALONE";

/// Other tests have threads of the library's: this one runs in a process of its own.
#[test]
fn threads_end_with_the_last_lens_and_with_shutdown() {
    if std::env::var_os(ALONE).is_none() {
        let name = "working::threads_end_with_the_last_lens_and_with_shutdown";
        let program = std::env::current_exe().expect("a program");
        let done = Command::new(program)
            .args(["--exact", name, "--nocapture"])
            .env(ALONE, "1")
            .output()
            .expect("it runs");
        let words = String::from_utf8_lossy(&done.stdout);
        assert!(
            done.status.success() && words.contains("1 passed"),
            "{words}"
        );
        return;
    }
    let source = Picture::busy(AREA, 3);
    let image = source.image();
    let plate = plate(&image, AREA);
    let lens = Held::new(2.0);
    let want = applied(&lens, &slow(), &plate, AREA).bits();
    let Some(count) = library_threads() else {
        return;
    };
    assert_eq!(count, 2);
    // SAFETY: nothing is asked of a caller.
    well(unsafe { (doors().shutdown)() });
    assert_eq!(library_threads(), Some(0));
    // They come back when there is work, and end with the last lens, also after a call was stopped.
    assert_eq!(applied(&lens, &slow(), &plate, AREA).bits(), want);
    let mut out = Picture::black(AREA, 3);
    let output = out.output();
    let mut told = Told::new(1);
    let callbacks = told.callbacks();
    // SAFETY: all pointers are good.
    let status = unsafe { (doors().apply)(lens.0, &slow(), &plate, &output, null(), &callbacks) };
    refused(status, SeidelStatus::Aborted, "said to stop");
    let second = Held::new(2.0);
    drop(lens);
    assert_eq!(library_threads(), Some(2));
    drop(second);
    assert_eq!(library_threads(), Some(0));
}

#[test]
fn memory_is_bounded_by_what_is_told_to_be_needed() {
    let lens = Held::new(2.0);
    let source = Picture::busy(AREA, 4);
    let image = source.image();
    let plate = plate(&image, AREA);
    let mut settings = settings();
    let mut out = Picture::black(AREA, 4);
    let output = out.output();
    for removal in [0, 1] {
        let mut needed = 0;
        // SAFETY: all pointers are good.
        unsafe {
            well((doors().memory)(&settings, &plate, removal, &mut needed));
            assert!(needed >= 160 * 120 * 4 * 16, "{needed}");
            let mut call = |memory: u64| {
                settings.memory = memory;
                match removal {
                    0 => (doors().apply)(lens.0, &settings, &plate, &output, null(), null()),
                    _ => (doors().remove)(
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
            refused(call(needed - 1), SeidelStatus::Memory, "settings.memory");
            well(call(needed));
        }
    }
}
