//! What pictures are to be of.

use std::ffi::CStr;

use super::{Answer, Call};
use crate::clips::{DEPTH, HOLDOUT, MASK};
use crate::host::{Clip, Result};
use crate::sys::clip::{ALPHA, PREMULTIPLICATION, RGB, RGBA};
use crate::sys::effect::{CLIP_SOURCE, COLOURSPACE, FRAME_VARYING};

/// Optional inputs, what asks for their components, and which of them they take.
const OPTIONAL: [(&CStr, &CStr, &[&CStr]); 3] = [
    (
        DEPTH,
        c"OfxImageClipPropComponents_Depth",
        &[ALPHA, RGB, RGBA],
    ),
    (
        HOLDOUT,
        c"OfxImageClipPropComponents_Holdout",
        &[ALPHA, RGB, RGBA],
    ),
    (MASK, c"OfxImageClipPropComponents_Mask", &[ALPHA, RGBA]),
];
const UNMAPPED_COMPONENTS: &CStr = c"OfxImageClipPropUnmappedComponents";
const COLOURS_SOURCE: &CStr = c"OfxImageClipPropPreferredColourspaces_Source";
const COLOURS_DEPTH: &CStr = c"OfxImageClipPropPreferredColourspaces_Depth";

/// Asks for depth and mattes as they are, and says of the output what holds of the source.
pub(super) fn preferences(call: &Call) -> Result<Answer> {
    // Otherwise hosts may turn one channel into four, and do not say where it went: HostSupport gives every optional input
    // the components of the plate.
    for (name, property, known) in OPTIONAL {
        let Some(clip) = call.effect.clip(name).filter(Clip::is_connected) else {
            continue;
        };
        let has = clip.properties.string(UNMAPPED_COMPONENTS, 0);
        let own = known
            .iter()
            .find(|name| has.as_deref().map(str::as_bytes) == Some(name.to_bytes()));
        if let Some(own) = own {
            call.answers.set_string(property, 0, own);
        }
        if name == DEPTH {
            call.answers.set_string(COLOURS_DEPTH, 0, c"ofx_raw");
        }
    }
    if let Some(source) = call.effect.clip(CLIP_SOURCE)
        && let Some(alpha) = source.properties.string(PREMULTIPLICATION, 0)
    {
        call.answers.set_text(PREMULTIPLICATION, &alpha);
    }
    call.answers
        .set_string(COLOURS_SOURCE, 0, c"ofx_scene_linear");
    call.answers.set_int(FRAME_VARYING, 0, 0);
    Ok(Answer::Done)
}

/// The result is in the source's colour space.
pub(super) fn colourspace(call: &Call) -> Result<Answer> {
    call.answers
        .set_string(COLOURSPACE, 0, c"OfxColourspace_Source");
    Ok(Answer::Done)
}
