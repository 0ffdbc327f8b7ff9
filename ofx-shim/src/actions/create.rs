//! Instances come and go. They keep nothing of their own: what they are is in their knobs.

use super::{Answer, Call, enabled, untell};
use crate::host::Result;
use crate::sys::property::TIME;

/// Shows the knobs that count.
pub(super) fn create(call: &Call) -> Result<Answer> {
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    enabled::show(&call.effect, time);
    Ok(Answer::Done)
}

/// Nothing is told of one that is gone.
pub(super) fn destroy(call: &Call) -> Result<Answer> {
    untell(call.host, call.effect.handle);
    crate::overlay::grid::forget(call.effect.handle.addr());
    Ok(Answer::Done)
}
