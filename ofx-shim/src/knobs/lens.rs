//! The lens groups: the lens and the strength of its blur; its data, channels and frame on the plate.

use std::ffi::CStr;

use seidel_core::HostGroup;

use super::{Group, Kind, Knob, Own, PresetMenu, Rows};
use crate::lens::built_in;

/// Mode: apply blur.
pub(crate) const APPLY: i32 = 0;
/// Mode: remove blur.
pub(crate) const REMOVE: i32 = 1;
/// Mode: replace the blur of one lens by another's.
pub(crate) const RELENS: i32 = 2;

pub(crate) static MODE: Knob = Knob {
    name: c"mode",
    label: c"Mode",
    hint: c"Apply: adds the blur of the lens to the plate. Remove: removes the blur of the lens that took the plate. Relens: replaces that blur by another lens's.",
    kind: Kind::Choice {
        default: APPLY,
        options: &[c"Apply", c"Remove", c"Relens"],
    },
};

pub(crate) static LENS: Knob = Knob {
    name: c"lens",
    label: c"Lens",
    hint: c"A lens that comes with Seidel, or a lens profile. The lenses that come with Seidel are designed, not measured.",
    kind: Kind::Choice {
        default: 1,
        options: built_in::NAMES,
    },
};

pub(crate) static PROFILE: Knob = Knob {
    name: c"profile",
    label: c"Lens File",
    hint: c"Lens profile from `seidel fit`. Used if Lens is Lens File.",
    kind: Kind::File,
};

pub(crate) static FOLDER: Knob = Knob {
    name: c"lensFolder",
    label: c"Lens Folder",
    hint: c"Profiles in the folder that the environment variable SEIDEL_LENSES names: a choice goes to Lens and Lens File. The menu is read when the plugin is loaded.",
    kind: Kind::Presets(PresetMenu::LensFolder),
};

pub(crate) static RELOAD: Knob = Knob {
    name: c"reload",
    label: c"Reload",
    hint: c"Reads lens profiles and OpenColorIO configs again.",
    kind: Kind::Button,
};

/// Counts reloads, so that the host's cache of rendered images becomes out of date.
pub(crate) static RELOADS: Knob = Knob {
    name: c"reloads",
    label: c"Reloads",
    hint: c"Number of reloads.",
    kind: Kind::Hidden,
};

pub(crate) static TO_LENS: Knob = Knob {
    name: c"toLens",
    label: c"To Lens",
    hint: c"Relens: the lens whose blur is added.",
    kind: Kind::Choice {
        default: 2,
        options: built_in::NAMES,
    },
};

pub(crate) static TO_PROFILE: Knob = Knob {
    name: c"toProfile",
    label: c"To Lens File",
    hint: c"Relens: lens profile from `seidel fit`. Used if To Lens is Lens File.",
    kind: Kind::File,
};

pub(crate) static DATA: Knob = Knob {
    name: c"lensData",
    label: c"Lens Data",
    hint: c"Sets focus distance, f-number, focal length and film back from what the shot knows, where their knobs are as measured or 0: OpenEXR frames by a pattern such as plate.####.exr, whose attributes are read, or a table of the shot (OpenTrackIO, ARRI, RED, Sony, Canon, Blackmagic). Distances in scene units are in the unit of the depth pass.",
    kind: Kind::File,
};

pub(crate) static DATA_START: Knob = Knob {
    name: c"lensDataStart",
    label: c"Lens Data Start",
    hint: c"Frame of the first row of the table. Empty: the table's own frame numbers.",
    kind: Kind::Text,
};

pub(crate) static SHOW_DATA: Knob = Knob {
    name: c"showLensData",
    label: c"Show Lens Data",
    hint: c"Lists what Lens Data sets at this frame, with the source of each value.",
    kind: Kind::Button,
};

/// A factor on the strength of the blur of one channel.
const fn scale(name: &'static CStr, label: &'static CStr, hint: &'static CStr) -> Knob {
    Knob {
        name,
        label,
        hint,
        kind: Kind::Number {
            default: 1.0,
            range: (0.001, 16.0),
            slider: (0.5, 1.5),
            digits: 3,
        },
    }
}

pub(crate) static RED_SCALE: Knob = scale(
    c"redScale",
    c"Red Scale",
    c"Strength of the blur of red, times Amount. For lenses with a red channel.",
);

pub(crate) static GREEN_SCALE: Knob = scale(
    c"greenScale",
    c"Green Scale",
    c"Strength of the blur of green, times Amount. For lenses with a green channel.",
);

pub(crate) static BLUE_SCALE: Knob = scale(
    c"blueScale",
    c"Blue Scale",
    c"Strength of the blur of blue, times Amount. For lenses with a blue channel.",
);

/// Lens frame: on the project's format.
pub(crate) const FRAME_PROJECT: i32 = 0;

pub(crate) static FRAME: Knob = Knob {
    name: c"frame",
    label: c"Lens Frame",
    hint: c"Rectangle on which the lens's frame is centred: the project's format, or the extent of the source if its size is another.",
    kind: Kind::Choice {
        default: FRAME_PROJECT,
        options: &[c"Project Format", c"Source Extent"],
    },
};

pub(crate) static AXIS_OFFSET: Knob = Knob {
    name: c"axisOffset",
    label: c"Axis Offset (px)",
    hint: c"Offset of the optical axis from the centre, in pixels at full resolution: for plates cropped off-centre.",
    kind: Kind::Pair {
        default: (0.0, 0.0),
        position: false,
    },
};

/// The knobs of the core's table with which most shots are set up.
const MAIN: &[&str] = &["amount", "focal-length-mm", "f-number"];

pub(crate) static GROUP: Group = Group {
    name: c"lensGroup",
    label: c"Lens",
    open: true,
    own: &[
        Own::first(&MODE),
        Own::first(&LENS),
        Own::first(&PROFILE),
        Own::first(&FOLDER),
        Own::first(&RELOAD),
        Own::first(&RELOADS),
        Own::first(&TO_LENS),
        Own::first(&TO_PROFILE),
    ],
    table: Rows::Only(HostGroup::Lens, MAIN),
};

pub(crate) static DETAILS: Group = Group {
    name: c"lensDetailsGroup",
    label: c"Lens Details",
    open: false,
    own: &[
        Own::first(&DATA),
        Own::first(&DATA_START),
        Own::first(&SHOW_DATA),
        Own::first(&RED_SCALE),
        Own::first(&GREEN_SCALE),
        Own::first(&BLUE_SCALE),
        Own::after("geometry", &FRAME),
        Own::after("film-back-mm", &AXIS_OFFSET),
    ],
    table: Rows::But(HostGroup::Lens, MAIN),
};
