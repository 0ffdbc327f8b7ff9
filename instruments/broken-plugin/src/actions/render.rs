//! Render.

use std::ffi::{CStr, c_uint, c_void};
use std::sync::atomic::{AtomicBool, Ordering};

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::image_effect::*;

use super::Call;
use super::regions::source_region;
use crate::api::MessageFormat;
use crate::blur::weights;
use crate::faults::Fault;
use crate::image::{Image, ImageError};
use crate::state::{LAST_RENDER, RENDERS};

/// Bytes that [`Fault::KeepsFrames`] keeps of each frame.
const KEPT_BYTES: usize = 20_000;

/// A render, shared by its threads.
struct Job<'a> {
    call: &'a Call<'a>,
    output: Image<'a>,
    source: Option<Image<'a>>,
    depth: Option<Image<'a>>,
    mask: Option<Image<'a>>,
    /// The render window: x1, y1, x2, y2.
    window: [i32; 4],
    weights_x: Vec<f32>,
    weights_y: Vec<f32>,
    rows: FieldRows,
    mix: f32,
    /// Factor of the result; 1 without faults.
    gain: f32,
    /// Identifies the render for [`Fault::SharedState`].
    ticket: usize,
    aborted: AtomicBool,
}

// SAFETY: each thread writes its own rows of the output and reads the rest.
unsafe impl Sync for Job<'_> {}

/// The rows to render: all, or those of one field.
#[derive(Clone, Copy)]
struct FieldRows {
    step: i32,
    first: i32,
}

impl FieldRows {
    fn of_field(field: &str) -> Self {
        let (step, first) = match field {
            "OfxFieldLower" => (2, 0),
            "OfxFieldUpper" => (2, 1),
            _ => (1, 0),
        };
        Self { step, first }
    }

    fn contains(self, y: i32) -> bool {
        (y - self.first).rem_euclid(self.step) == 0
    }
}

pub(super) fn render(call: &Call<'_>) -> OfxStatus {
    match prepare(call) {
        Ok(job) => {
            LAST_RENDER.store(job.ticket, Ordering::SeqCst);
            render_on_threads(&job);
            kOfxStatOK
        }
        Err(status) => status,
    }
}

/// Fetches images and reads parameters.
///
/// # Errors
/// The status of Render.
fn prepare<'a>(call: &'a Call<'a>) -> Result<Job<'a>, OfxStatus> {
    let (time, effect) = (call.time(), call.effect);
    let window = call
        .in_args
        .ints::<4>(kOfxImageEffectPropRenderWindow)
        .ok_or(kOfxStatFailed)?;
    check_file(call)?;
    call.clear_message();
    let output = fetch_output(call)?;
    let source = fetch_source(call, output.channels)?;
    let fetch_if = |parameter: &CStr, clip: &CStr| {
        let is_used = effect.boolean(parameter, time).unwrap_or(false);
        is_used
            .then(|| Image::fetch(effect, clip, time, call.fault).ok())
            .flatten()
    };
    let scale = match call.fault {
        Fault::IgnoresScale => [1.0; 2],
        _ => call.render_scale(),
    };
    let par = (effect.clip(c"Source"))
        .and_then(|clip| clip.properties.double(kOfxImagePropPixelAspectRatio, 0))
        .filter(|par| *par > 0.0)
        .unwrap_or(1.0);
    let par = match call.fault {
        Fault::WrongAspect => 1.0 / par,
        _ => par,
    };
    let field = call.in_args.string(kOfxImageEffectPropFieldToRender);
    let rows = FieldRows::of_field(&field.unwrap_or_default());
    let row_step = match call.fault {
        Fault::MixesFields => 1,
        _ => rows.step,
    };
    let size = call.size();
    let half_width = |pixels: f64| {
        if size > 0.0 {
            (size + 0.5) * pixels
        } else {
            0.5
        }
    };
    if call.fault == Fault::KeepsFrames {
        std::mem::forget(std::hint::black_box(vec![0_u8; KEPT_BYTES]));
    }
    let gain = match call.fault {
        Fault::Accumulates => 1.0 + RENDERS.fetch_add(1, Ordering::SeqCst) as f32,
        _ => 1.0,
    };
    Ok(Job {
        call,
        depth: fetch_if(c"useDepth", c"Depth"),
        mask: fetch_if(c"useMask", c"Mask"),
        output,
        source,
        window,
        weights_x: weights(half_width(scale[0] / par)),
        weights_y: weights(half_width(scale[1] / f64::from(row_step))),
        rows,
        mix: effect.double(c"mix", time).unwrap_or(1.0) as f32,
        gain,
        ticket: time as usize + 1,
        aborted: AtomicBool::new(false),
    })
}

impl Call<'_> {
    fn render_scale(&self) -> [f64; 2] {
        let scale = self.in_args.doubles(kOfxImageEffectPropRenderScale);
        scale.unwrap_or([1.0; 2])
    }
}

/// Checks that the file exists, if one is named.
fn check_file(call: &Call<'_>) -> Result<(), OfxStatus> {
    let file = call.effect.string(c"file", call.time()).unwrap_or_default();
    if file.is_empty() || std::path::Path::new(&file).exists() {
        return Ok(());
    }
    let format = match call.fault {
        Fault::MessageAsFormat => MessageFormat::Format,
        Fault::MessageWithArgument => MessageFormat::Argument,
        _ => MessageFormat::Escaped,
    };
    let text = format!("{file}: the file does not exist; choose another");
    call.effect.post_error(&text, format);
    Err(kOfxStatFailed)
}

fn fetch_output<'a>(call: &Call<'a>) -> Result<Image<'a>, OfxStatus> {
    // Other faults of images concern inputs only.
    let fault = match call.fault {
        Fault::IgnoresBitDepth => call.fault,
        fault if fault.takes_bytes() => fault,
        _ => Fault::None,
    };
    Image::fetch(call.effect, c"Output", call.time(), fault).map_err(|error| match error {
        ImageError::Missing => kOfxStatFailed,
        ImageError::Unsupported => {
            let text = "the host's images are not of a supported bit depth; convert them first";
            call.effect.post_error(text, MessageFormat::Escaped);
            kOfxStatErrImageFormat
        }
    })
}

fn fetch_source<'a>(call: &Call<'a>, channels: usize) -> Result<Option<Image<'a>>, OfxStatus> {
    let mut source = match Image::fetch(call.effect, c"Source", call.time(), call.fault) {
        Ok(source) if source.channels == channels => source,
        Err(ImageError::Missing) => return Ok(None),
        _ => return Err(kOfxStatErrImageFormat),
    };
    if call.fault == Fault::TrustsRegion
        && let Some([_, _, x2, y2]) = source_region(call)
    {
        let scale = call.render_scale();
        source.bounds[2] = source.bounds[2].min((x2 * scale[0]) as i32);
        source.bounds[3] = source.bounds[3].min((y2 * scale[1]) as i32);
    }
    let source = source.with_release_fault(call.fault);
    if call.fault == Fault::RejectsNarrow && source.bounds[2] - source.bounds[0] < 2 {
        return Err(kOfxStatFailed);
    }
    Ok(Some(source))
}

/// Renders on the host's threads, if it has any, else on this one.
fn render_on_threads(job: &Job<'_>) {
    let suite = job.call.effect.suites.threads;
    let faulty = match job.call.fault {
        Fault::UsesMissingSuite => suite.is_none(),
        Fault::CallsNullFunction => suite.is_some_and(|s| s.multiThreadNumCPUs.is_none()),
        _ => false,
    };
    if faulty {
        // SAFETY: none; this is the fault.
        unsafe { std::ptr::read_volatile(std::ptr::null::<usize>()) };
    }
    let mut count: c_uint = 1;
    if let Some(num_cpus) = suite.and_then(|suite| suite.multiThreadNumCPUs) {
        // SAFETY: memory for a number.
        if unsafe { num_cpus(&raw mut count) } != kOfxStatOK {
            count = 1;
        }
    }
    let argument = (job as *const Job<'_>).cast_mut().cast::<c_void>();
    if let Some(multi_thread) = suite.and_then(|suite| suite.multiThread)
        && count > 1
        // SAFETY: the argument is of the function's type, and the call returns when all threads have.
        && unsafe { multi_thread(Some(render_share), count, argument) } == kOfxStatOK
    {
        return;
    }
    render_rows(job, 0, 1);
}

unsafe extern "C" fn render_share(index: c_uint, count: c_uint, job: *mut c_void) {
    // SAFETY: the argument that `render_on_threads` passes.
    let job = unsafe { &*job.cast_const().cast::<Job<'_>>() };
    // A panic must not reach the host; the unwritten rows show it.
    let _ = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        render_rows(job, index as i32, count as i32);
    }));
}

/// Renders the share of one of `count` threads: consecutive rows of the window.
fn render_rows(job: &Job<'_>, index: i32, count: i32) {
    let [_, y1, _, y2] = job.window;
    let height = i64::from(y2) - i64::from(y1);
    if height <= 0 {
        return;
    }
    let start = |index: i32| y1 + (height * i64::from(index) / i64::from(count)) as i32;
    let (from, mut to) = (start(index), start(index + 1));
    if job.call.fault == Fault::WritesOutside && index + 1 == count {
        to += 1;
    }
    for y in (from..to).filter(|y| job.rows.contains(*y)) {
        if is_aborted(job) {
            return;
        }
        let is_brightened = y == from
            && match job.call.fault {
                Fault::ThreadDependent => true,
                Fault::WideBlurThreadDependent => job.weights_x.len() > 20,
                _ => false,
            };
        render_row(job, y, if is_brightened { 1.5 } else { job.gain });
    }
}

fn is_aborted(job: &Job<'_>) -> bool {
    if let Some(abort) = job.call.effect.suites.effect.abort
        && !job.aborted.load(Ordering::SeqCst)
        // SAFETY: the effect is being rendered.
        && unsafe { abort(job.call.effect.handle) } != 0
        && job.call.fault != Fault::IgnoresAbort
    {
        job.aborted.store(true, Ordering::SeqCst);
    }
    job.aborted.load(Ordering::SeqCst)
}

fn render_row(job: &Job<'_>, y: i32, mut gain: f32) {
    let [x1, _, x2, y2] = job.window;
    let fault = job.call.fault;
    if fault == Fault::SharedState {
        std::thread::yield_now();
        if LAST_RENDER.load(Ordering::SeqCst) != job.ticket {
            gain = 2.0;
        }
    }
    for x in x1..x2 {
        if fault == Fault::UnwrittenPixel && x + 1 == x2 && y + 1 == y2 {
            continue;
        }
        let is_outside_mask = job.mask.as_ref().is_some_and(|mask| !mask.contains(x, y));
        if fault == Fault::WritesMaskOnly && is_outside_mask {
            continue;
        }
        if fault == Fault::WrongOrigin {
            gain = 1.0 + x as f32 * 0.01;
        }
        let mix = match fault {
            Fault::DoesNothing => 0.0,
            _ => job.mix * blur_amount(job, x, y),
        };
        let skips_alpha = fault == Fault::UnwrittenAlpha && (x + 1, y + 1) == (x2, y2);
        for c in 0..job.output.channels {
            if skips_alpha && c == 3 {
                continue;
            }
            let blurred = box_mean(job, x, y, c) * gain;
            let sharp = job.source.as_ref().map_or(0.0, |s| s.get(x, y, c));
            job.output.set(x, y, c, sharp + (blurred - sharp) * mix);
        }
    }
}

/// Returns the amount of blur of a pixel, from depth and mask.
fn blur_amount(job: &Job<'_>, x: i32, y: i32) -> f32 {
    let depth = job.depth.as_ref().map_or(1.0, |depth| {
        let channel = match job.call.fault {
            Fault::WrongChannel => depth.channels - 1,
            _ => 0,
        };
        (depth.get(x, y, channel) / 5.0).clamp(0.0, 1.0)
    });
    let mask = job.mask.as_ref().map_or(1.0, |mask| {
        mask.get(x, y, mask.channels - 1).clamp(0.0, 1.0)
    });
    depth * mask
}

/// Returns the weighted mean over the box, in rows of the same field.
fn box_mean(job: &Job<'_>, x: i32, y: i32, c: usize) -> f32 {
    let Some(source) = &job.source else {
        return 0.0;
    };
    let [x1, y1, x2, y2] = job.window;
    let step = match job.call.fault {
        Fault::MixesFields => 1,
        _ => job.rows.step,
    };
    let radius_x = job.weights_x.len() as i32 - 1;
    let radius_y = job.weights_y.len() as i32 - 1;
    let mut sum = 0.0;
    for j in -radius_y..=radius_y {
        let row = y + j * step;
        let mut row_sum = 0.0;
        for i in -radius_x..=radius_x {
            let is_outside = x + i < x1 || x + i >= x2 || row < y1 || row >= y2;
            if job.call.fault != Fault::Seams || !is_outside {
                row_sum += source.get(x + i, row, c) * job.weights_x[i.unsigned_abs() as usize];
            }
        }
        sum += row_sum * job.weights_y[j.unsigned_abs() as usize];
    }
    sum
}
