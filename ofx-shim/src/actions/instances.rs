//! CreateInstance and DestroyInstance. Instances have no state of their own: it is all in their parameters.

use super::{Answer, enabled, guess_depth, persistent_message};
use crate::host::{Call, Result};

/// Enables the parameters that have an effect.
pub(super) fn create(call: &Call) -> Result<Answer> {
    enabled::update(&call.effect, call.time());
    Ok(Answer::Done)
}

/// Forgets the instance without a call of the host: hosts on HostSupport call this while their own side of the instance is
/// being destroyed, and a message function would end the process.
pub(super) fn destroy(call: &Call) -> Result<Answer> {
    persistent_message::forget(call.effect.handle);
    guess_depth::forget(call.effect.handle);
    crate::overlay::forget(call.effect.handle.addr());
    Ok(Answer::Done)
}
