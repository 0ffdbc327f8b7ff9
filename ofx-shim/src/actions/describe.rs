//! What the plugin is.

use super::{Answer, Call};
use crate::clips::SUPPORTS_TILES;
use crate::host::Result;
use crate::sys::clip::DEPTH_FLOAT;
use crate::sys::effect as e;
use crate::sys::property::{LABEL, LONG_LABEL, PLUGIN_DESCRIPTION, SHORT_LABEL, VERSION};

const DESCRIPTION: &str = "Real lens blur. Puts the blur of a lens on a plate, field by field, channel by channel and \
depth by depth; takes it off a plate; or turns the blur of one lens into that of another. Lenses are profiles that \
`seidel fit` learns from measured point-spread functions. Works on linear light.";

/// Sets the descriptor's properties; older hosts do not know all of them.
pub(super) fn describe(call: &Call) -> Result<Answer> {
    let props = call.effect.properties();
    for label in [LABEL, SHORT_LABEL, LONG_LABEL] {
        props.set_string(label, 0, c"Seidel");
    }
    props.set_text(PLUGIN_DESCRIPTION, DESCRIPTION);
    for (index, part) in env!("CARGO_PKG_VERSION").split('.').enumerate() {
        props.set_int(VERSION, index as i32, part.parse().unwrap_or(0));
    }
    props.set_string(e::GROUPING, 0, c"Filter");
    props.set_string(e::SUPPORTED_CONTEXTS, 0, e::CONTEXT_FILTER);
    props.set_string(e::SUPPORTED_CONTEXTS, 1, e::CONTEXT_GENERAL);
    // Half is read where it comes, but not asked for: some hosts, such as MLT, would turn better samples into it.
    props.set_string(e::SUPPORTED_PIXEL_DEPTHS, 0, DEPTH_FLOAT);
    props.set_string(e::THREAD_SAFETY, 0, e::FULLY_SAFE);
    for (name, value) in [
        (e::MULTIPLE_CLIP_DEPTHS, 1),
        (e::MULTIPLE_CLIP_PARS, 0),
        // Depth and masks may be of another size than the plate.
        (e::MULTI_RESOLUTION, 1),
        (e::TILES, SUPPORTS_TILES),
        (e::TEMPORAL_CLIP_ACCESS, 0),
        // Threads are the library's own: a host that splits frames would have each part rendered as a whole.
        (e::HOST_FRAME_THREADING, 0),
        (e::SINGLE_INSTANCE, 0),
        (e::FIELD_RENDER_TWICE, 1),
    ] {
        props.set_int(name, 0, value);
    }
    props.set_string(e::NO_SPATIAL_AWARENESS, 0, c"false");
    props.set_string(e::CPU_RENDER, 0, c"true");
    props.set_string(e::OPENGL_RENDER, 0, c"false");
    props.set_string(e::COLOUR_STYLE, 0, e::COLOUR_BASIC);
    props.set_string(e::COLOUR_CONFIGS, 0, c"ofx-native-v1.5_aces-v1.3_ocio-v2.3");
    crate::overlay::declare(call.host, &props);
    Ok(Answer::Done)
}
