//! GetRegionOfDefinition: the result is as large as the source, whatever else is connected.

use super::Answer;
use crate::host::{Call, Result};
use crate::sys::effect::{CLIP_SOURCE, REGION_OF_DEFINITION};

/// Answers with the region of the source.
pub(super) fn region(call: &Call) -> Result<Answer> {
    let source = call.effect.clip(CLIP_SOURCE);
    let Some(rod) = source.and_then(|clip| clip.region_of_definition(call.time())) else {
        return Ok(Answer::Default);
    };
    let corners = [rod.x1, rod.y1, rod.x2, rod.y2];
    call.answers.set_doubles(REGION_OF_DEFINITION, &corners);
    Ok(Answer::Done)
}
