//! How large the result is: as large as the source, whatever else is connected.

use super::{Answer, Call};
use crate::host::Result;
use crate::sys::effect::{CLIP_SOURCE, REGION_OF_DEFINITION};
use crate::sys::property::TIME;

/// Answers the source's region.
pub(super) fn region(call: &Call) -> Result<Answer> {
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    let source = call.effect.clip(CLIP_SOURCE);
    let Some(rod) = source.and_then(|clip| clip.region_of_definition(time)) else {
        return Ok(Answer::Default);
    };
    let corners = [rod.x1, rod.y1, rod.x2, rod.y2];
    call.answers.set_doubles(REGION_OF_DEFINITION, &corners);
    Ok(Answer::Done)
}
