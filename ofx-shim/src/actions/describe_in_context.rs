//! Which clips and knobs it has: the same in all contexts.

use super::{Answer, Call};
use crate::host::Result;
use crate::{clips, knobs};

/// Declares them.
pub(super) fn describe(call: &Call) -> Result<Answer> {
    clips::declare(&call.effect);
    knobs::declare(&call.effect);
    Ok(Answer::Done)
}
