//! Whether the plate shows the blur of the lens, asked by the user.

use std::ffi::c_void;
use std::ptr::null;

use seidel_c::{SeidelCallbacks, SeidelPlate, SeidelStatus, seidel_check_lens};

use super::Call;
use super::render::chosen_lens;
use crate::colour::Codes;
use crate::ffi;
use crate::host::{Failure, ParameterValue, Result, show_information};
use crate::knobs::{Knobs, lens};
use crate::pixels::Pixels;
use crate::rendering::{Copied, Frame, Inputs, is_unpremultiplied, progress};
use crate::setup::{Circumstances, Setup};
use crate::sys::effect::CLIP_SOURCE;

/// Compares the blur of the source with the lens's, sets Amount to what the source shows where that is less, and says what
/// was found, or why nothing was. Only for the main thread.
pub(super) fn check(call: &Call, time: f64) {
    let text = match checked(call, time) {
        Ok(Some(text)) => text,
        Ok(None) => return,
        Err(failure) => failure.text,
    };
    show_information(call.host, call.effect.handle, &text);
}

/// What was found; nothing where the host wanted it no more.
fn checked(call: &Call, time: f64) -> Result<Option<String>> {
    let knobs = Knobs::at(&call.effect, time);
    let clip = call.effect.clip(CLIP_SOURCE);
    let source = clip.as_ref().map_or(Ok(None), |clip| clip.image(time))?;
    let (Some(clip), Some(source)) = (&clip, &source) else {
        return Err(Failure::failed(
            "Check Lens: there is no source; connect the plate.",
        ));
    };
    let lens = chosen_lens(&knobs, (&lens::LENS, &lens::PROFILE))?;
    let frame = Frame::new(
        call,
        &knobs,
        (clip, source),
        (time, source.bounds),
        source.bounds,
    );
    let inputs = Inputs::new(call, &knobs, (&lens.info, &frame.plane), time)?;
    let about = Circumstances {
        scale: frame.scale,
        field: frame.field,
        unpremultiplied: is_unpremultiplied(&knobs, clip, source),
        draft: false,
        threads: call.host.threads(),
    };
    let setup = Setup::new(&knobs, &lens.info, &about)?;
    let Some(image) = frame.plane.image(source, 0, source.channels) else {
        return Ok(None);
    };
    let codes = Codes::of(&knobs, !about.unpremultiplied, about.threads)?;
    // SAFETY: the picture is held.
    let pixels = unsafe { Pixels::new(image) };
    let light = codes.map(|codes| codes.light(&pixels, image.rect));
    let mut light = light.transpose()?;
    let image = light.as_mut().map_or(image, Copied::image);
    let plate = SeidelPlate {
        size: size_of::<SeidelPlate>() as u64,
        format: frame.format,
        extent: frame.extent,
        source: &raw const image,
        depth: inputs
            .depth
            .as_ref()
            .map_or(null(), |made| &raw const made.image),
        matte: null(),
        matte_depth: null(),
        alphas: null(),
    };
    let callbacks = SeidelCallbacks {
        size: size_of::<SeidelCallbacks>() as u64,
        user: (&raw const call.effect).cast::<c_void>().cast_mut(),
        progress: Some(progress),
    };
    let mut share = 1.0;
    let settings = setup.settings();
    // SAFETY: all that is pointed to is held until the call ends, and the pictures are the host's for this action.
    let status =
        unsafe { seidel_check_lens(lens.handle(), settings, &plate, &raw mut share, &callbacks) };
    if status == SeidelStatus::Aborted {
        return Ok(None);
    }
    ffi::done(status)?;
    let amount = knobs.number(&lens::AMOUNT);
    let percent = 100.0 * share;
    Ok(Some(if share < 1.0 {
        let amount = amount * share;
        (call.effect.parameters()).set(
            c"Check Lens",
            &[(lens::AMOUNT.name, ParameterValue::Double(amount))],
        );
        format!(
            "The plate shows about {percent:.0} % of the lens's blur, so Amount is {amount:.3} now: to remove more would \
             ring. Undo this if the lens is right."
        )
    } else if share > 1.0 {
        format!(
            "The plate shows about {percent:.0} % of the lens's blur. Is it the plate's lens, and at the plate's distance?"
        )
    } else {
        "Nothing in the plate speaks against the lens.".to_owned()
    }))
}
