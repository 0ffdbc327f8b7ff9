//! Which lens, and how strong.

use std::ffi::CStr;

use super::{Group, Kind, Knob};
use crate::lens::built_in;

/// Mode: put blur on.
pub(crate) const APPLY: i32 = 0;
/// Mode: take it off.
pub(crate) const REMOVE: i32 = 1;
/// Mode: take one lens's off and put another's on.
pub(crate) const RELENS: i32 = 2;

pub(crate) static MODE: Knob = Knob {
    name: c"mode",
    label: c"Mode",
    hint: c"Apply puts the blur of the lens on the plate. Remove takes the blur of the lens that the plate was taken with off it. Relens takes it off and puts that of another lens on.",
    kind: Kind::Choice {
        default: APPLY,
        options: &[c"Apply", c"Remove", c"Relens"],
    },
};

pub(crate) static LENS: Knob = Knob {
    name: c"lens",
    label: c"Lens",
    hint: c"A lens that comes with Seidel, or one of a file. Those that come with it are designed, not measured.",
    kind: Kind::Choice {
        default: 1,
        options: built_in::NAMES,
    },
};

pub(crate) static PROFILE: Knob = Knob {
    name: c"profile",
    label: c"Lens File",
    hint: c"Lens profile, as `seidel fit` writes it. Counts where Lens says Lens File.",
    kind: Kind::File,
};

pub(crate) static RELOAD: Knob = Knob {
    name: c"reload",
    label: c"Reload",
    hint: c"Reads lens files and colour configs again.",
    kind: Kind::Button,
};

/// Counts what was reloaded, so that the host's own caches know.
pub(crate) static RELOADS: Knob = Knob {
    name: c"reloads",
    label: c"Reloads",
    hint: c"How many times files were read again.",
    kind: Kind::Hidden,
};

pub(crate) static TO_LENS: Knob = Knob {
    name: c"toLens",
    label: c"To Lens",
    hint: c"Relens: the lens whose blur is put on.",
    kind: Kind::Choice {
        default: 2,
        options: built_in::NAMES,
    },
};

pub(crate) static TO_PROFILE: Knob = Knob {
    name: c"toProfile",
    label: c"To Lens File",
    hint: c"Relens: lens profile of the lens whose blur is put on. Counts where To Lens says Lens File.",
    kind: Kind::File,
};

pub(crate) static AMOUNT: Knob = Knob {
    name: c"amount",
    label: c"Amount",
    hint: c"How strong blur and displacement are: 0 leaves the plate as it is, 1 is as measured.",
    kind: Kind::Number {
        default: 1.0,
        range: (0.0, 16.0),
        slider: (0.0, 2.0),
        digits: 3,
    },
};

/// How strong the blur of one colour is besides.
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
    c"How strong the blur of red is besides. For lenses that have this channel.",
);

pub(crate) static GREEN_SCALE: Knob = scale(
    c"greenScale",
    c"Green Scale",
    c"How strong the blur of green is besides. For lenses that have this channel.",
);

pub(crate) static BLUE_SCALE: Knob = scale(
    c"blueScale",
    c"Blue Scale",
    c"How strong the blur of blue is besides. For lenses that have this channel.",
);

pub(crate) static F_STOP: Knob = Knob {
    name: c"fStop",
    label: c"F Stop",
    hint: c"Stops the lens down to this f-number. 0: as measured. For lenses known ray by ray.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 256.0),
        slider: (0.0, 22.0),
        digits: 2,
    },
};

pub(crate) static SENSOR_SHIFT: Knob = Knob {
    name: c"sensorShift",
    label: c"Sensor Shift",
    hint: c"Moves the sensor away from the lens, micrometres. For lenses known ray by ray.",
    kind: Kind::Number {
        default: 0.0,
        range: (-1e5, 1e5),
        slider: (-200.0, 200.0),
        digits: 1,
    },
};

pub(crate) static GEOMETRY: Knob = Knob {
    name: c"geometry",
    label: c"Geometry",
    hint: c"None: blur alone. Lateral: channels are displaced against each other, the plate stays undistorted. Full: distortion and lateral colour.",
    kind: Kind::Choice {
        default: 1,
        options: &[c"None", c"Lateral", c"Full"],
    },
};

/// The lens's frame is as wide as the project.
pub(crate) const FRAME_PROJECT: i32 = 0;

pub(crate) static FRAME: Knob = Knob {
    name: c"frame",
    label: c"Lens Frame",
    hint: c"What the lens's frame is laid on, centre on centre: the project's format, or all of the source where that is of another size.",
    kind: Kind::Choice {
        default: FRAME_PROJECT,
        options: &[c"Project Format", c"Source Extent"],
    },
};

pub(crate) static LENS_SCALE: Knob = Knob {
    name: c"lensScale",
    label: c"Lens Scale",
    hint: c"Plate pixels per pixel of the lens's frame at full resolution. 0: the format is as wide as the frame.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 1000.0),
        slider: (0.0, 4.0),
        digits: 4,
    },
};

pub(crate) static AXIS_OFFSET: Knob = Knob {
    name: c"axisOffset",
    label: c"Axis Offset",
    hint: c"Moves the optical axis from where it would be, pixels at full resolution: for plates cropped off the middle.",
    kind: Kind::Pair {
        default: (0.0, 0.0),
        position: false,
    },
};

pub(crate) static GROUP: Group = Group {
    name: c"lensGroup",
    label: c"Lens",
    open: true,
    knobs: &[
        &MODE,
        &LENS,
        &PROFILE,
        &RELOAD,
        &RELOADS,
        &TO_LENS,
        &TO_PROFILE,
        &AMOUNT,
        &RED_SCALE,
        &GREEN_SCALE,
        &BLUE_SCALE,
        &F_STOP,
        &SENSOR_SHIFT,
        &GEOMETRY,
        &FRAME,
        &LENS_SCALE,
        &AXIS_OFFSET,
    ],
};
