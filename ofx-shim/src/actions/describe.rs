//! Describe: name, contexts and abilities of the plugin.

use super::Answer;
use crate::clips::SUPPORTS_TILES;
use crate::host::{Call, Result};
use crate::sys::clip::DEPTH_FLOAT;
use crate::sys::effect as e;
use crate::sys::property::{LABEL, LONG_LABEL, PLUGIN_DESCRIPTION, SHORT_LABEL, VERSION};

const DESCRIPTION: &str = "Real lens blur. Applies the blur of a lens to a plate, by position in the field, colour channel and \
depth; removes it from a plate; or replaces the blur of one lens by that of another. Lenses are profiles that \
`seidel fit` learns from measured point-spread functions. Works on scene-linear images.";

/// Sets the properties of the descriptor. Older hosts ignore some.
pub(super) fn describe(call: &Call) -> Result<Answer> {
    let properties = call.effect.properties();
    for label in [LABEL, SHORT_LABEL, LONG_LABEL] {
        properties.set_string(label, 0, c"Seidel");
    }
    properties.set_text(PLUGIN_DESCRIPTION, DESCRIPTION);
    for (index, part) in env!("CARGO_PKG_VERSION").split('.').enumerate() {
        properties.set_int(VERSION, index as i32, part.parse().unwrap_or(0));
    }
    properties.set_string(e::GROUPING, 0, c"Filter");
    properties.set_string(e::SUPPORTED_CONTEXTS, 0, e::CONTEXT_FILTER);
    properties.set_string(e::SUPPORTED_CONTEXTS, 1, e::CONTEXT_GENERAL);
    // Half is read too, but not requested: some hosts, such as MLT, would convert better samples to it.
    properties.set_string(e::SUPPORTED_PIXEL_DEPTHS, 0, DEPTH_FLOAT);
    properties.set_string(e::THREAD_SAFETY, 0, e::FULLY_SAFE);
    for (name, value) in [
        (e::MULTIPLE_CLIP_DEPTHS, 1),
        (e::MULTIPLE_CLIP_PARS, 0),
        // Depth and masks may differ from the plate in size.
        (e::MULTI_RESOLUTION, 1),
        (e::TILES, SUPPORTS_TILES),
        (e::TEMPORAL_CLIP_ACCESS, 0),
        // Seidel has threads of its own. A host that splits frames would have each part rendered as a whole frame.
        (e::HOST_FRAME_THREADING, 0),
        (e::SINGLE_INSTANCE, 0),
        (e::FIELD_RENDER_TWICE, 1),
    ] {
        properties.set_int(name, 0, value);
    }
    properties.set_string(e::NO_SPATIAL_AWARENESS, 0, c"false");
    properties.set_string(e::CPU_RENDER, 0, c"true");
    properties.set_string(e::OPENGL_RENDER, 0, c"false");
    properties.set_string(e::COLOUR_STYLE, 0, e::COLOUR_BASIC);
    properties.set_string(e::COLOUR_CONFIGS, 0, c"ofx-native-v1.5_aces-v1.3_ocio-v2.3");
    crate::overlay::declare(call.host, &properties);
    Ok(Answer::Done)
}
