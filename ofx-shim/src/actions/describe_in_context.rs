//! DescribeInContext: the clips and parameters, which are the same in all contexts.

use super::Answer;
use crate::host::{Call, Result};
use crate::{clips, knobs};

/// Declares clips and parameters.
pub(super) fn describe(call: &Call) -> Result<Answer> {
    clips::declare(&call.effect);
    knobs::declare(&call.effect);
    Ok(Answer::Done)
}
