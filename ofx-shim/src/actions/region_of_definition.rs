//! GetRegionOfDefinition: the region of the source, grown by the reach of the blur where it is expanded.

use super::Answer;
use super::identity::is_identity;
use crate::expansion::expanded_region;
use crate::host::{Call, Result};
use crate::knobs::Knobs;
use crate::rendering::project_region;
use crate::sys::effect::{CLIP_SOURCE, REGION_OF_DEFINITION};

/// Answers with the region of the result.
pub(super) fn region(call: &Call) -> Result<Answer> {
    let Some(source) = call.effect.clip(CLIP_SOURCE) else {
        return Ok(Answer::Default);
    };
    let Some(rod) = source.region_of_definition(call.time()) else {
        return Ok(Answer::Default);
    };
    let knobs = Knobs::at(&call.effect, call.time());
    let rod = if is_identity(&knobs) {
        rod
    } else {
        expanded_region(call, &knobs, &source, rod, project_region(call))
    };
    let corners = [rod.x1, rod.y1, rod.x2, rod.y2];
    call.answers.set_doubles(REGION_OF_DEFINITION, &corners);
    Ok(Answer::Done)
}
