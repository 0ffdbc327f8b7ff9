//! IsIdentity: whether the result is the source.

use super::{Answer, persistent_message};
use crate::host::{Call, Result};
use crate::knobs::{Knobs, lens, named, output};
use crate::sys::effect::CLIP_SOURCE;
use crate::sys::property::{NAME, TIME};

/// Names the source clip if the result is the source.
pub(super) fn action(call: &Call) -> Result<Answer> {
    // Nuke does not render until a message is cleared, and calls this first.
    persistent_message::clear(call.host, call.effect.handle);
    let time = call.time();
    if !is_identity(&Knobs::at(&call.effect, time)) {
        return Ok(Answer::Default);
    }
    call.answers.set_string(NAME, 0, CLIP_SOURCE);
    call.answers.set_double(TIME, 0, time);
    Ok(Answer::Done)
}

/// Returns whether the parameters leave the plate as it is: no blur, or a mix of 0.
pub(super) fn is_identity(knobs: &Knobs) -> bool {
    if knobs.choice(&output::OUTPUT) != output::RESULT {
        return false;
    }
    let mode = knobs.choice(&lens::MODE);
    knobs.number(&output::MIX) == 0.0
        || knobs.number(named("amount")) == 0.0
        || (mode == lens::REMOVE && knobs.number(named("strength")) == 0.0)
}
