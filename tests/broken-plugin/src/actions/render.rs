//! The picture.

use std::ffi::{c_uint, c_void};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::Call;
use crate::blur::weights;
use crate::faults::Fault;
use crate::image::{Image, Missing};
use crate::state::{RENDERS, SCRATCH};

/// What all threads of a render need.
struct Work<'a> {
    call: &'a Call<'a>,
    output: Image<'a>,
    source: Option<Image<'a>>,
    depth: Option<Image<'a>>,
    mask: Option<Image<'a>>,
    window: [i32; 4],
    across: Vec<f32>,
    up: Vec<f32>,
    /// 2 where rows of one field are rendered alone.
    step: i32,
    first: i32,
    mix: f32,
    gain: f32,
    ticket: usize,
    stop: AtomicBool,
    threads: AtomicUsize,
}

// SAFETY: threads write rows of their own, and read the rest.
unsafe impl Sync for Work<'_> {}

pub(super) fn render(call: &Call<'_>) -> OfxStatus {
    let (time, effect) = (call.time(), call.effect);
    let Some(window) = call.given.ints::<4>(kOfxImageEffectPropRenderWindow) else {
        return kOfxStatFailed;
    };
    let file = effect.string(c"file", time).unwrap_or_default();
    if !file.is_empty() && !std::path::Path::new(&file).exists() {
        let text = format!("{file}: cannot be read; choose a file that is there");
        effect.complain(&text, call.fault == Fault::FormatMessage);
        return kOfxStatFailed;
    }
    if call.fault != Fault::KeepsMessage {
        effect.content(call.fault == Fault::ClearsAlways);
    }
    let of_output = match call.fault {
        Fault::TakesAnySamples => call.fault,
        _ => Fault::None,
    };
    let output = match Image::of(effect, c"Output", time, of_output) {
        Ok(output) => output,
        Err(Missing::Empty) => return kOfxStatFailed,
        Err(Missing::Unusable) => {
            let text = "the host gives pictures that are not of floats; convert them first";
            effect.complain(text, false);
            return kOfxStatErrImageFormat;
        }
    };
    let source = match Image::of(effect, c"Source", time, call.fault) {
        Ok(mut source) if source.channels == output.channels => {
            if call.fault == Fault::TrustsRegion
                && let Some([_, _, x2, y2]) = super::regions::source_region(call)
            {
                let scale = call.given.doubles::<2>(kOfxImageEffectPropRenderScale);
                let [across, up] = scale.unwrap_or([1.0; 2]);
                source.bounds[2] = source.bounds[2].min((x2 * across) as i32);
                source.bounds[3] = source.bounds[3].min((y2 * up) as i32);
            }
            Some(source.with_fault(call.fault))
        }
        Err(Missing::Empty) => None,
        _ => return kOfxStatErrImageFormat,
    };
    if call.fault == Fault::RefusesSmall
        && source
            .as_ref()
            .is_some_and(|s| s.bounds[2] - s.bounds[0] < 2)
    {
        return kOfxStatFailed;
    }
    let extra = |clip, knob| {
        effect
            .boolean(knob, time)
            .unwrap_or(false)
            .then(|| Image::of(effect, clip, time, call.fault).ok())
            .flatten()
    };
    let mut scale = call
        .given
        .doubles::<2>(kOfxImageEffectPropRenderScale)
        .unwrap_or([1.0; 2]);
    if call.fault == Fault::IgnoresScale {
        scale = [1.0; 2];
    }
    let par = (effect.clip(c"Source"))
        .and_then(|(_, set)| set.double(kOfxImagePropPixelAspectRatio, 0))
        .filter(|par| *par > 0.0)
        .unwrap_or(1.0);
    let par = if call.fault == Fault::WrongAspect {
        1.0 / par
    } else {
        par
    };
    let field = call
        .given
        .text(kOfxImageEffectPropFieldToRender)
        .unwrap_or_default();
    let (step, first) = match field.as_str() {
        "OfxFieldLower" => (2, 0),
        "OfxFieldUpper" => (2, 1),
        _ => (1, 0),
    };
    let size = call.size();
    let half = |pixels: f64| {
        if size > 0.0 {
            (size + 0.5) * pixels
        } else {
            0.5
        }
    };
    let rows = if call.fault == Fault::MixesFields {
        1
    } else {
        step
    };
    let gain = match call.fault {
        Fault::Accumulates => 1.0 + RENDERS.fetch_add(1, Ordering::SeqCst) as f32,
        _ => 1.0,
    };
    let work = Work {
        call,
        depth: extra(c"Depth", c"useDepth"),
        mask: extra(c"Mask", c"useMask"),
        output,
        source,
        window,
        across: weights(half(scale[0] / par)),
        up: weights(half(scale[1] / f64::from(rows))),
        step,
        first,
        mix: effect.double(c"mix", time).unwrap_or(1.0) as f32,
        gain,
        ticket: time as usize + 1,
        stop: AtomicBool::new(false),
        threads: AtomicUsize::new(0),
    };
    SCRATCH.store(work.ticket, Ordering::SeqCst);
    run(&work);
    kOfxStatOK
}

/// On the host's threads if it has any, else here.
fn run(work: &Work<'_>) {
    let suite = work.call.effect.suites.threads;
    if work.call.fault == Fault::NullSuite && suite.is_none() {
        // SAFETY: it is not: this is the fault.
        unsafe { std::ptr::read_volatile(std::ptr::null::<usize>()) };
    }
    if work.call.fault == Fault::NullMember
        && suite.is_some_and(|suite| suite.multiThreadNumCPUs.is_none())
    {
        // SAFETY: as above.
        unsafe { std::ptr::read_volatile(std::ptr::null::<usize>()) };
    }
    let several = suite.and_then(|suite| suite.multiThread);
    let mut count: c_uint = 1;
    if let Some(ask) = suite.and_then(|suite| suite.multiThreadNumCPUs) {
        // SAFETY: room for a number.
        if unsafe { ask(&raw mut count) } != kOfxStatOK {
            count = 1;
        }
    }
    let argument = (work as *const Work<'_>).cast_mut().cast::<c_void>();
    if let Some(several) = several
        && count > 1
        // SAFETY: the function and its argument belong together; the call ends when all threads have.
        && unsafe { several(Some(share), count, argument) } == kOfxStatOK
    {
        return;
    }
    rows(work, 0, 1);
}

unsafe extern "C" fn share(index: c_uint, count: c_uint, work: *mut c_void) {
    // SAFETY: what `run` gave.
    let work = unsafe { &*work.cast_const().cast::<Work<'_>>() };
    let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        rows(work, index as i32, count as i32);
    }));
    work.threads
        .fetch_add(usize::from(caught.is_ok()), Ordering::SeqCst);
}

/// The rows of one thread: its share of the window, from the bottom.
fn rows(work: &Work<'_>, index: i32, count: i32) {
    let [_, y1, _, y2] = work.window;
    let height = i64::from(y2) - i64::from(y1);
    if height <= 0 {
        return;
    }
    let part = |n: i32| y1 + (height * i64::from(n) / i64::from(count)) as i32;
    let (from, mut to) = (part(index), part(index + 1));
    if work.call.fault == Fault::WritesOutside && index + 1 == count {
        to += 1;
    }
    for y in from..to {
        if (y - work.first).rem_euclid(work.step) != 0 {
            continue;
        }
        if stopped(work) {
            return;
        }
        let dependent = y == from
            && match work.call.fault {
                Fault::ThreadDependent => true,
                Fault::WideThreads => work.across.len() > 20,
                _ => false,
            };
        row(work, y, if dependent { 1.5 } else { work.gain });
    }
}

fn stopped(work: &Work<'_>) -> bool {
    if let Some(abort) = work.call.effect.suites.effect.abort
        && !work.stop.load(Ordering::SeqCst)
        // SAFETY: the effect is being rendered.
        && unsafe { abort(work.call.effect.handle) } != 0
        && work.call.fault != Fault::IgnoresAbort
    {
        work.stop.store(true, Ordering::SeqCst);
    }
    work.stop.load(Ordering::SeqCst)
}

fn row(work: &Work<'_>, y: i32, gain: f32) {
    let [x1, _, x2, y2] = work.window;
    let fault = work.call.fault;
    let mut gain = gain;
    if fault == Fault::SharedScratch {
        std::thread::yield_now();
        if SCRATCH.load(Ordering::SeqCst) != work.ticket {
            gain = 2.0;
        }
    }
    for x in x1..x2 {
        if fault == Fault::LeavesPixel && x + 1 == x2 && y + 1 == y2 {
            continue;
        }
        let masked = work.mask.as_ref().is_some_and(|mask| !mask.has(x, y));
        if fault == Fault::MaskedOnly && masked {
            continue;
        }
        if fault == Fault::WrongOrigin {
            gain = 1.0 + x as f32 * 0.01;
        }
        for c in 0..work.output.channels {
            let blurred = boxed(work, x, y, c) * gain;
            let as_it_is = work.source.as_ref().map_or(0.0, |s| s.get(x, y, c));
            let share = match fault {
                Fault::DoesNothing => 0.0,
                _ => work.mix * amount(work, x, y),
            };
            work.output
                .put(x, y, c, as_it_is + (blurred - as_it_is) * share);
        }
    }
}

/// How much of the blur a pixel gets by depth and mask.
fn amount(work: &Work<'_>, x: i32, y: i32) -> f32 {
    let depth = work.depth.as_ref().map_or(1.0, |depth| {
        let last = depth.channels - 1;
        let channel = if work.call.fault == Fault::WrongChannel {
            last
        } else {
            0
        };
        (depth.get(x, y, channel) / 5.0).clamp(0.0, 1.0)
    });
    let mask = work.mask.as_ref().map_or(1.0, |mask| {
        mask.get(x, y, mask.channels - 1).clamp(0.0, 1.0)
    });
    depth * mask
}

/// The mean over the box, of rows of the same field.
fn boxed(work: &Work<'_>, x: i32, y: i32, c: usize) -> f32 {
    let Some(source) = &work.source else {
        return 0.0;
    };
    let [x1, y1, x2, y2] = work.window;
    let mixes = work.call.fault == Fault::MixesFields;
    let step = if mixes { 1 } else { work.step };
    let (rx, ry) = (work.across.len() as i32 - 1, work.up.len() as i32 - 1);
    let mut sum = 0.0;
    for j in -ry..=ry {
        let mut line = 0.0;
        let at = y + j * step;
        for i in -rx..=rx {
            let cut = work.call.fault == Fault::Seams
                && (x + i < x1 || x + i >= x2 || at < y1 || at >= y2);
            if !cut {
                line += source.get(x + i, at, c) * work.across[i.unsigned_abs() as usize];
            }
        }
        sum += line * work.up[j.unsigned_abs() as usize];
    }
    sum
}
