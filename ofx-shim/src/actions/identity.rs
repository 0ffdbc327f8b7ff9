//! Whether nothing is done, so that the source is the result.

use super::{Answer, Call, untell};
use crate::host::Result;
use crate::knobs::{Knobs, lens, output, remove};
use crate::lens::built_in;
use crate::sys::effect::CLIP_SOURCE;
use crate::sys::property::{NAME, TIME};

/// Answers the host.
pub(super) fn action(call: &Call) -> Result<Answer> {
    // Nuke does not render before a message is taken back, and asks this before.
    untell(call.host, call.effect.handle);
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    if !is_identity(&Knobs::at(&call.effect, time)) {
        return Ok(Answer::Default);
    }
    call.answers.set_string(NAME, 0, CLIP_SOURCE);
    call.answers.set_double(TIME, 0, time);
    Ok(Answer::Done)
}

/// Whether knobs leave the plate as it is: nothing of the blur, nothing of the result, or no lens chosen yet.
pub(super) fn is_identity(knobs: &Knobs) -> bool {
    if knobs.choice(&output::OUTPUT) != output::RESULT {
        return false;
    }
    let mode = knobs.choice(&lens::MODE);
    let unset =
        |choice, file| knobs.choice(choice) == built_in::FILE && knobs.text(file).trim().is_empty();
    knobs.number(&output::MIX) == 0.0
        || knobs.number(&lens::AMOUNT) == 0.0
        || (mode == lens::REMOVE && knobs.number(&remove::STRENGTH) == 0.0)
        || unset(&lens::LENS, &lens::PROFILE)
        || (mode == lens::RELENS && unset(&lens::TO_LENS, &lens::TO_PROFILE))
}
