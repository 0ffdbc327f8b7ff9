//! Calls of the C ABI from many threads on one lens and on lenses of their own.

use std::ffi::c_char;
use std::fs;
use std::ptr::{null, null_mut};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use seidel_c::*;

use super::Watch;
use crate::options::Options;
use crate::seeds::{HEIGHT, WIDTH, lenses, sample};

/// Threads that call.
const THREADS: usize = 8;

/// Different calls; threads repeat them.
const VARIANTS: usize = 60;

/// Channels of the images.
const CHANNELS: usize = 3;

/// Most time that the threads of the library take to end.
const END: Duration = Duration::from_secs(10);

/// A lens handle, which any thread may use.
#[derive(Clone, Copy)]
struct Handle(*mut SeidelLens);

// SAFETY: any thread may use a handle.
unsafe impl Send for Handle {}
// SAFETY: several threads may use a handle at the same time.
unsafe impl Sync for Handle {}

/// The result of a call.
#[derive(Clone, PartialEq)]
struct Outcome {
    status: SeidelStatus,
    error: String,
    samples: Vec<u32>,
}

/// Makes `calls` calls, and compares the outcome of each with that of the same call before there were threads.
pub(super) fn run(calls: usize, _: &Options, watch: &mut Watch) -> Result<(), String> {
    let threads_before = threads();
    let json = lenses::lens();
    let lens = open(&json)?;
    let expected: Vec<Outcome> = (0..VARIANTS).map(|k| call(lens, k)).collect();
    let is_refused = |outcome: &&Outcome| outcome.status != SeidelStatus::Ok;
    let refused = expected.iter().filter(is_refused).count();
    if !(1..VARIANTS / 5).contains(&refused) {
        return Err(format!("{refused} of {VARIANTS} calls are refused"));
    }
    watch.begin(std::process::id());
    let (next, json, expected) = (AtomicUsize::new(0), &json, &expected);
    let work = || -> Result<(), String> {
        loop {
            let number = next.fetch_add(1, Relaxed);
            if number >= calls {
                return Ok(());
            }
            let variant = number % VARIANTS;
            // Each hundredth call opens its own lens.
            let own = if number % 100 == 7 {
                Some(open(json)?)
            } else {
                None
            };
            let outcome = call(own.unwrap_or(lens), variant);
            if let Some(own) = own {
                seidel_lens_release(own.0);
            }
            if outcome != expected[variant] {
                let text = format!("call {number} ({:?}: {})", outcome.status, outcome.error);
                return Err(format!("{text} differs from the first of its kind"));
            }
        }
    };
    let results: Vec<Result<(), String>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS).map(|_| scope.spawn(work)).collect();
        let ended = threads.into_iter().map(|thread| thread.join());
        ended
            .map(|result| result.unwrap_or_else(|_| Err("a thread panicked".to_owned())))
            .collect()
    });
    seidel_lens_release(lens.0);
    results.into_iter().collect::<Result<(), _>>()?;
    // That of the watch goes on.
    let started = Instant::now();
    while threads() > threads_before + 1 {
        if started.elapsed() > END {
            return Err("threads of the library remain after its last lens".to_owned());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Ok(())
}

/// Returns the number of threads of this process.
fn threads() -> usize {
    fs::read_dir("/proc/self/task").map_or(0, Iterator::count)
}

fn open(json: &str) -> Result<Handle, String> {
    let mut lens = null_mut();
    // SAFETY: the text has the stated length, and the pointer to the handle is valid.
    let status = unsafe { seidel_lens_read(json.as_ptr().cast::<c_char>(), json.len(), &mut lens) };
    if status == SeidelStatus::Ok {
        Ok(Handle(lens))
    } else {
        Err(format!("the lens is refused: {}", last_error()))
    }
}

/// Makes the call of a variant: mostly renders, some queries, and a tenth that is refused.
fn call(lens: Handle, variant: usize) -> Outcome {
    let rect = SeidelRect {
        left: 0,
        top: 0,
        width: WIDTH as i32,
        height: HEIGHT as i32,
    };
    let mut source: Vec<f32> = (0..WIDTH * HEIGHT * CHANNELS)
        .map(|k| {
            let (pixel, channel) = (k / CHANNELS, k % CHANNELS);
            sample(pixel % WIDTH + variant, pixel / WIDTH, channel)
        })
        .collect();
    let mut out = vec![0.0_f32; source.len()];
    let describe = |samples: &mut Vec<f32>| SeidelImage {
        size: size_of::<SeidelImage>() as u64,
        data: samples.as_mut_ptr().cast(),
        row_bytes: (WIDTH * CHANNELS * size_of::<f32>()) as i64,
        pixel_bytes: 0,
        channels: CHANNELS as u32,
        sample: SEIDEL_FLOAT,
        reserved: 0,
        rect,
    };
    let (input, output) = (describe(&mut source), describe(&mut out));
    let plate = SeidelPlate {
        size: size_of::<SeidelPlate>() as u64,
        format: rect,
        extent: rect,
        source: &input,
        depth: null(),
        matte: null(),
        matte_depth: null(),
        alphas: null(),
        mask: null(),
    };
    let settings = settings(variant);
    // SAFETY: the images have the stated sizes, and all pointers are null or valid for the call.
    let status = unsafe {
        match variant % 12 {
            3 => {
                let mut region = rect;
                seidel_region_of_interest(lens.0, &settings, &plate, &rect, &mut region)
            }
            5 => {
                let mut share = 0.0;
                seidel_check_lens(lens.0, &settings, &plate, &mut share, null())
            }
            7 => seidel_relens(lens.0, lens.0, &settings, &plate, &output, null(), null()),
            11 => seidel_remove(
                lens.0,
                &settings,
                &plate,
                &output,
                null(),
                null_mut(),
                null(),
            ),
            _ => seidel_apply(lens.0, &settings, &plate, &output, null(), null()),
        }
    };
    let error = if status == SeidelStatus::Ok {
        String::new()
    } else {
        last_error()
    };
    Outcome {
        status,
        error,
        samples: out.iter().map(|v| v.to_bits()).collect(),
    }
}

fn settings(variant: usize) -> SeidelSettings {
    // SAFETY: every field is a number or a pointer, and zero is valid for both.
    let mut settings: SeidelSettings = unsafe { std::mem::zeroed() };
    settings.size = size_of::<SeidelSettings>() as u64;
    // SAFETY: the struct has the size that it states.
    unsafe { seidel_settings_init(&mut settings) };
    settings.distance = 1.5 + 0.1 * variant as f64;
    settings.amount = 0.5 + 0.02 * variant as f64;
    settings.quality = SEIDEL_QUALITY_DRAFT;
    settings.threads = 1 + (variant % 3) as u32;
    if variant % 10 == 9 {
        settings.distance = -1.0;
    }
    settings
}

fn last_error() -> String {
    let mut words = [0_u8; 600];
    // SAFETY: the buffer has the stated length.
    unsafe { seidel_last_error(words.as_mut_ptr().cast(), words.len()) };
    let end = words.iter().position(|&b| b == 0).unwrap_or(words.len());
    String::from_utf8_lossy(&words[..end]).into_owned()
}
