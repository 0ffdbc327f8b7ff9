//! The work itself, done by the library.

use std::ffi::c_void;
use std::ptr::{null, null_mut};
use std::sync::Arc;

use seidel_c::{
    SeidelCallbacks, SeidelFindings, SeidelImage, SeidelPlate, SeidelStatus, seidel_apply,
    seidel_relens, seidel_remove,
};

use super::{Frame, Inputs};
use crate::depth::Made;
use crate::ffi;
use crate::host::{Effect, Failure, Result};
use crate::knobs::{lens, output};
use crate::lens::Lens;
use crate::setup::Setup;

/// The lens of a render, and the other one of relens.
pub(crate) struct Lenses {
    pub(crate) lens: Arc<Lens>,
    pub(crate) to: Option<Arc<Lens>>,
}

/// What is to be done.
pub(crate) struct Task<'a> {
    pub(crate) effect: Effect<'a>,
    pub(crate) mode: i32,
    pub(crate) output: i32,
    pub(crate) frame: &'a Frame,
    pub(crate) inputs: &'a Inputs<'a>,
    pub(crate) setup: &'a Setup,
    pub(crate) source: SeidelImage,
    /// Where results go: pixels of the extent alone.
    pub(crate) target: SeidelImage,
}

/// Whether it was done, or the host wanted it no more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done,
    Aborted,
}

/// Asks the host, on the thread that it called, whether to stop.
pub(crate) unsafe extern "C" fn progress(user: *mut c_void, _share: f64) -> i32 {
    // SAFETY: it is the effect that `perform` gave, which lives until the call ends.
    let effect = unsafe { &*user.cast::<Effect>() };
    let stop = crate::host::catch_panic(|| effect.is_aborted());
    i32::from(stop.unwrap_or(false))
}

fn address(made: &Option<Made>) -> *const SeidelImage {
    made.as_ref().map_or(null(), |made| &raw const made.image)
}

/// Does the work.
///
/// # Errors
/// What the library says; outputs that the mode has not.
pub(crate) fn perform(task: &Task, lenses: &Lenses) -> Result<Outcome> {
    let maps = [output::CONFIDENCE, output::NOISE_GAIN].contains(&task.output);
    if maps && task.mode != lens::REMOVE {
        return Err(Failure::failed(
            "Output: Confidence and Noise Gain are of removal; set Mode to Remove, or Output to Result.",
        ));
    }
    let plate = SeidelPlate {
        size: size_of::<SeidelPlate>() as u64,
        format: task.frame.format,
        extent: task.frame.extent,
        source: &raw const task.source,
        depth: address(&task.inputs.depth),
        matte: address(&task.inputs.matte),
        matte_depth: address(&task.inputs.matte_depth),
        alphas: null(),
    };
    let callbacks = SeidelCallbacks {
        size: size_of::<SeidelCallbacks>() as u64,
        user: (&raw const task.effect).cast_mut().cast(),
        progress: Some(progress),
    };
    let (settings, target) = (task.setup.settings(), &raw const task.target);
    let handle = lenses.lens.handle();
    // SAFETY: all that is pointed to is held until the calls end, and each picture is the host's for this render.
    let status = unsafe {
        match (task.mode, &lenses.to) {
            (lens::RELENS, Some(to)) => seidel_relens(
                handle,
                to.handle(),
                settings,
                &plate,
                target,
                null(),
                &callbacks,
            ),
            (lens::REMOVE, _) if maps => return mapped(task, handle, &plate, &callbacks),
            (lens::REMOVE, _) => seidel_remove(
                handle,
                settings,
                &plate,
                target,
                null(),
                null_mut(),
                &callbacks,
            ),
            _ => seidel_apply(handle, settings, &plate, target, null(), &callbacks),
        }
    };
    finished(status)
}

fn finished(status: SeidelStatus) -> Result<Outcome> {
    match status {
        SeidelStatus::Aborted => Ok(Outcome::Aborted),
        other => ffi::done(other).map(|()| Outcome::Done),
    }
}

/// Puts a map of the removal in place of the picture, which goes nowhere.
///
/// # Safety
/// As of [`seidel_remove`].
unsafe fn mapped(
    task: &Task,
    handle: *const seidel_c::SeidelLens,
    plate: &SeidelPlate,
    callbacks: &SeidelCallbacks,
) -> Result<Outcome> {
    let target = task.target;
    let rect = target.rect;
    let channels = target.channels as usize;
    let count = rect.width as usize * rect.height as usize * channels;
    let mut picture: Vec<f32> = Vec::new();
    picture
        .try_reserve_exact(count)
        .map_err(|_| Failure::memory(format!("Output: no memory for {count} samples.")))?;
    picture.resize(count, 0.0);
    let elsewhere = SeidelImage {
        data: picture.as_mut_ptr().cast(),
        row_bytes: (4 * channels) as i64 * i64::from(rect.width),
        pixel_bytes: 0,
        sample: seidel_c::SEIDEL_FLOAT,
        ..target
    };
    // A map has one channel a colour.
    let map = SeidelImage {
        channels: if target.channels == 1 { 1 } else { 3 },
        ..target
    };
    let wanted = &raw const map;
    let mut findings = match task.output {
        output::CONFIDENCE => SeidelFindings {
            confidence: wanted,
            ..ffi::findings()
        },
        _ => SeidelFindings {
            noise_gain: wanted,
            ..ffi::findings()
        },
    };
    // SAFETY: as the caller vouches.
    let status = unsafe {
        seidel_remove(
            handle,
            task.setup.settings(),
            plate,
            &elsewhere,
            null(),
            &raw mut findings,
            callbacks,
        )
    };
    if status == SeidelStatus::Ok && target.channels == 4 {
        // SAFETY: the target is the host's for this render.
        let pixels = unsafe { crate::pixels::Pixels::new(target) };
        pixels.each(rect, |pixels, place| pixels.put(place, 3, 1.0));
    }
    finished(status)
}
