//! What pictures are to be of.

use std::ffi::CStr;

use super::{Answer, Call};
use crate::clips::DEPTH;
use crate::host::Result;
use crate::sys::clip::{ALPHA, PREMULTIPLICATION, RGB, RGBA};
use crate::sys::effect::{CLIP_SOURCE, COLOURSPACE, FRAME_VARYING};

const COMPONENTS_DEPTH: &CStr = c"OfxImageClipPropComponents_Depth";
const UNMAPPED_COMPONENTS: &CStr = c"OfxImageClipPropUnmappedComponents";
const COLOURS_SOURCE: &CStr = c"OfxImageClipPropPreferredColourspaces_Source";
const COLOURS_DEPTH: &CStr = c"OfxImageClipPropPreferredColourspaces_Depth";

/// Asks for depth as it is, and says of the output what holds of the source.
pub(super) fn preferences(call: &Call) -> Result<Answer> {
    // Otherwise hosts may turn one channel into four, and do not say where it went.
    if let Some(depth) = call.effect.clip(DEPTH).filter(|clip| clip.is_connected()) {
        let has = depth.props.string(UNMAPPED_COMPONENTS, 0);
        let known = [ALPHA, RGB, RGBA];
        let own = known
            .into_iter()
            .find(|name| has.as_deref().map(str::as_bytes) == Some(name.to_bytes()));
        if let Some(own) = own {
            call.answers.set_string(COMPONENTS_DEPTH, 0, own);
        }
        call.answers.set_string(COLOURS_DEPTH, 0, c"ofx_raw");
    }
    if let Some(source) = call.effect.clip(CLIP_SOURCE)
        && let Some(alpha) = source.props.string(PREMULTIPLICATION, 0)
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
