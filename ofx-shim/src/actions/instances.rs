//! Instances come and go. They keep nothing of their own: what they are is in their knobs.

use super::{Answer, Call, enabled, told};
use crate::host::Result;
use crate::sys::property::TIME;

/// Shows the knobs that count.
pub(super) fn create(call: &Call) -> Result<Answer> {
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    enabled::show(&call.effect, time);
    Ok(Answer::Done)
}

/// Nothing is told of one that is gone, nor taken back: hosts on HostSupport call this while their own side of the
/// instance is being torn down, and a message function would end the process.
pub(super) fn destroy(call: &Call) -> Result<Answer> {
    told::forget(call.effect.handle);
    crate::overlay::forget(call.effect.handle.addr());
    Ok(Answer::Done)
}
