//! GetClipPreferences and GetOutputColourspace: components and colour spaces of the clips.

use std::ffi::CStr;

use super::Answer;
use crate::clips::{APERTURE, DEPTH, HOLDOUT, MASK, REFERENCE};
use crate::host::{Call, Clip, Result};
use crate::knobs::{Knobs, lens};
use crate::sys::clip::{ALPHA, PREMULTIPLICATION, RGB, RGBA};
use crate::sys::effect::{CLIP_SOURCE, COLOURSPACE, FRAME_VARYING};

/// An optional input whose components the plugin chooses.
struct OptionalInput {
    clip: &'static CStr,
    /// Property that requests components.
    property: &'static CStr,
    /// Components that the plugin accepts.
    components: &'static [&'static CStr],
}

const OPTIONAL_INPUTS: [OptionalInput; 5] = [
    OptionalInput {
        clip: DEPTH,
        property: c"OfxImageClipPropComponents_Depth",
        components: &[ALPHA, RGB, RGBA],
    },
    OptionalInput {
        clip: HOLDOUT,
        property: c"OfxImageClipPropComponents_Holdout",
        components: &[ALPHA, RGB, RGBA],
    },
    OptionalInput {
        clip: APERTURE,
        property: c"OfxImageClipPropComponents_Aperture",
        components: &[ALPHA, RGB, RGBA],
    },
    OptionalInput {
        clip: REFERENCE,
        property: c"OfxImageClipPropComponents_Reference",
        components: &[ALPHA, RGB, RGBA],
    },
    OptionalInput {
        clip: MASK,
        property: c"OfxImageClipPropComponents_Mask",
        components: &[ALPHA, RGBA],
    },
];
/// Properties that request components of the source and of the result.
const SOURCE_AND_OUTPUT: [&CStr; 2] = [
    c"OfxImageClipPropComponents_Source",
    c"OfxImageClipPropComponents_Output",
];
const UNMAPPED_COMPONENTS: &CStr = c"OfxImageClipPropUnmappedComponents";
const COLOURS_SOURCE: &CStr = c"OfxImageClipPropPreferredColourspaces_Source";
const COLOURS_DEPTH: &CStr = c"OfxImageClipPropPreferredColourspaces_Depth";

/// Requests all inputs with the components that they have, and gives the output those of the source, and its relation of colour
/// and alpha.
pub(super) fn preferences(call: &Call) -> Result<Answer> {
    // Otherwise hosts may turn one channel into four and do not say which one it is: HostSupport gives every optional input
    // the components of the plate.
    for input in &OPTIONAL_INPUTS {
        let clip = call.effect.clip(input.clip);
        let Some(clip) = clip.filter(Clip::is_connected) else {
            continue;
        };
        if let Some(own) = own_components(&clip, input.components) {
            call.answers.set_string(input.property, 0, own);
        }
        if input.clip == DEPTH {
            call.answers.set_string(COLOURS_DEPTH, 0, c"ofx_raw");
        }
    }
    if let Some(source) = call.effect.clip(CLIP_SOURCE) {
        if let Some(alpha) = source.properties.string(PREMULTIPLICATION, 0) {
            call.answers.set_text(PREMULTIPLICATION, &alpha);
        }
        // Otherwise Natron gives the output the most channels of any input, and leaves the source as it is.
        if let Some(own) = own_components(&source, &[ALPHA, RGB, RGBA]) {
            for property in SOURCE_AND_OUTPUT {
                call.answers.set_string(property, 0, own);
            }
        }
    }
    call.answers
        .set_string(COLOURS_SOURCE, 0, c"ofx_scene_linear");
    // A table or frames on disk change the result where no parameter does.
    let has_data = !Knobs::at(&call.effect, 0.0)
        .text(&lens::DATA)
        .trim()
        .is_empty();
    (call.answers).set_int(FRAME_VARYING, 0, i32::from(has_data));
    Ok(Answer::Done)
}

/// Returns the components that a clip has before the host maps them, if they are among `accepted`.
fn own_components<'a>(clip: &Clip, accepted: &[&'a CStr]) -> Option<&'a CStr> {
    let unmapped = clip.properties.string(UNMAPPED_COMPONENTS, 0)?;
    let mut accepted = accepted.iter().copied();
    accepted.find(|name| unmapped.as_bytes() == name.to_bytes())
}

/// Answers that the result is in the colour space of the source.
pub(super) fn colourspace(call: &Call) -> Result<Answer> {
    call.answers
        .set_string(COLOURSPACE, 0, c"OfxColourspace_Source");
    Ok(Answer::Done)
}
