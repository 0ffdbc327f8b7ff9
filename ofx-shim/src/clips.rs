//! The clips of the effect: names and accepted components.

use std::ffi::CStr;

use crate::host::Effect;
use crate::sys::clip::SUPPORTED_COMPONENTS;
use crate::sys::clip::{ALPHA, FIELD_BOTH, FIELD_EXTRACTION, IS_MASK, OPTIONAL, RGB, RGBA};
use crate::sys::effect::{CLIP_OUTPUT, CLIP_SOURCE, TEMPORAL_CLIP_ACCESS, TILES};
use crate::sys::property::LABEL;

/// Depth pass of the plate.
pub(crate) const DEPTH: &CStr = c"Depth";
/// Matte of something that will be composited in front of the plate.
pub(crate) const HOLDOUT: &CStr = c"Holdout";
/// Mask that limits the result to a part of the plate.
pub(crate) const MASK: &CStr = c"Mask";
/// Picture of the aperture, white where light passes.
pub(crate) const APERTURE: &CStr = c"Aperture";
/// Photograph that the result is compared with.
pub(crate) const REFERENCE: &CStr = c"Reference";

/// Support of tiles, which is not declared. Depth slices and highlights are found on the whole plate, and every tile must be
/// that part of the whole frame to the bit, so a tile costs as much as the frame. With depth, a 1920 x 1080 frame in tiles
/// of 256 x 256 px would be rendered forty times. Tiles that a host requests nevertheless are rendered.
pub(crate) const SUPPORTS_TILES: i32 = 0;

/// Declaration of a clip.
struct ClipDeclaration {
    name: &'static CStr,
    components: &'static [&'static CStr],
    optional: bool,
    mask: bool,
}

/// All clips, in the order in which hosts show them. In Nuke the first input determines the format of the output.
const ALL: [ClipDeclaration; 7] = [
    ClipDeclaration {
        name: CLIP_SOURCE,
        components: &[RGBA, RGB, ALPHA],
        optional: false,
        mask: false,
    },
    ClipDeclaration {
        name: DEPTH,
        components: &[RGBA, RGB, ALPHA],
        optional: true,
        mask: false,
    },
    ClipDeclaration {
        name: HOLDOUT,
        components: &[RGBA, RGB, ALPHA],
        optional: true,
        mask: false,
    },
    // Hosts such as Natron offer a menu of channels for masks; hosts that know RGBA alone deliver that.
    ClipDeclaration {
        name: MASK,
        components: &[ALPHA, RGBA],
        optional: true,
        mask: true,
    },
    ClipDeclaration {
        name: APERTURE,
        components: &[RGBA, RGB, ALPHA],
        optional: true,
        mask: false,
    },
    ClipDeclaration {
        name: REFERENCE,
        components: &[RGBA, RGB, ALPHA],
        optional: true,
        mask: false,
    },
    ClipDeclaration {
        name: CLIP_OUTPUT,
        components: &[RGBA, RGB, ALPHA],
        optional: false,
        mask: false,
    },
];

/// Declares all clips to a descriptor.
pub(crate) fn declare(effect: &Effect) {
    for clip in &ALL {
        let Some(properties) = effect.define_clip(clip.name) else {
            continue;
        };
        properties.set_string(LABEL, 0, clip.name);
        for (index, components) in clip.components.iter().enumerate() {
            properties.set_string(SUPPORTED_COMPONENTS, index as i32, components);
        }
        properties.set_int(OPTIONAL, 0, i32::from(clip.optional));
        properties.set_int(TEMPORAL_CLIP_ACCESS, 0, 0);
        properties.set_int(TILES, 0, SUPPORTS_TILES);
        properties.set_int(IS_MASK, 0, i32::from(clip.mask));
        // Whole frames: the plugin separates the fields itself, without copies.
        properties.set_string(FIELD_EXTRACTION, 0, FIELD_BOTH);
    }
}
