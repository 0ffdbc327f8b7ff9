//! The clips: which there are, and what they may hold.

use std::ffi::CStr;

use crate::host::Effect;
use crate::sys::clip::SUPPORTED_COMPONENTS;
use crate::sys::clip::{ALPHA, FIELD_BOTH, FIELD_EXTRACTION, IS_MASK, OPTIONAL, RGB, RGBA};
use crate::sys::effect::{CLIP_OUTPUT, CLIP_SOURCE, TEMPORAL_CLIP_ACCESS, TILES};
use crate::sys::property::LABEL;

/// Depth of the plate.
pub(crate) const DEPTH: &CStr = c"Depth";
/// What will be in front.
pub(crate) const HOLDOUT: &CStr = c"Holdout";
/// Where the result goes over the source.
pub(crate) const MASK: &CStr = c"Mask";

/// Whether parts of pictures may be asked for. A part costs what the whole does: depth slices and the lights that are
/// drawn apart are told by all of the plate, and every part must be that part of the whole to the bit. With depth a
/// 1920 x 1080 frame in 256 x 256 tiles would be rendered forty times over. Hosts that ask for parts all the same get them.
pub(crate) const SUPPORTS_TILES: i32 = 0;

/// A clip as it is declared.
struct Declared {
    name: &'static CStr,
    components: &'static [&'static CStr],
    optional: bool,
    mask: bool,
}

/// In the order in which hosts show them; the first input gives the output its format (Nuke).
const ALL: [Declared; 5] = [
    Declared {
        name: CLIP_SOURCE,
        components: &[RGBA, RGB, ALPHA],
        optional: false,
        mask: false,
    },
    Declared {
        name: DEPTH,
        components: &[RGBA, RGB, ALPHA],
        optional: true,
        mask: false,
    },
    Declared {
        name: HOLDOUT,
        components: &[RGBA, RGB, ALPHA],
        optional: true,
        mask: false,
    },
    // Hosts such as Natron give masks a menu of channels; those that know RGBA alone hand in that.
    Declared {
        name: MASK,
        components: &[ALPHA, RGBA],
        optional: true,
        mask: true,
    },
    Declared {
        name: CLIP_OUTPUT,
        components: &[RGBA, RGB, ALPHA],
        optional: false,
        mask: false,
    },
];

/// Declares all to a descriptor.
pub(crate) fn declare(effect: &Effect) {
    for clip in &ALL {
        let Some(props) = effect.define_clip(clip.name) else {
            continue;
        };
        props.set_string(LABEL, 0, clip.name);
        for (index, components) in clip.components.iter().enumerate() {
            props.set_string(SUPPORTED_COMPONENTS, index as i32, components);
        }
        props.set_int(OPTIONAL, 0, i32::from(clip.optional));
        props.set_int(TEMPORAL_CLIP_ACCESS, 0, 0);
        props.set_int(TILES, 0, SUPPORTS_TILES);
        props.set_int(IS_MASK, 0, i32::from(clip.mask));
        // Whole frames: fields are told apart here, without copies.
        props.set_string(FIELD_EXTRACTION, 0, FIELD_BOTH);
    }
}
