//! What is in focus, and how fast blur grows about it.

use super::{Group, Kind, Knob};

/// Focus: as the lens was when it was measured.
pub(crate) const AS_MEASURED: i32 = 0;
/// Focus: at a distance in metres.
pub(crate) const AT_DISTANCE: i32 = 1;
/// Focus: at a value of the depth.
pub(crate) const AT_DEPTH: i32 = 2;

pub(crate) static FOCUS: Knob = Knob {
    name: c"focus",
    label: c"Focus",
    hint: c"As Measured: the lens is focused as it was when it was measured. Otherwise at Focus Distance, or where the depth is Focus Plane (C).",
    kind: Kind::Choice {
        default: AS_MEASURED,
        options: &[c"As Measured", c"Focus Distance", c"Focus Plane (C)"],
    },
};

pub(crate) static DISTANCE: Knob = Knob {
    name: c"focusDistance",
    label: c"Focus Distance",
    hint:
        c"Distance that is in focus, metres, where Focus says so. A million and more is infinity.",
    kind: Kind::Number {
        default: 2.0,
        range: (0.001, 1e6),
        slider: (0.1, 20.0),
        digits: 3,
    },
};

pub(crate) static PLANE: Knob = Knob {
    name: c"focusPlane",
    label: c"Focus Plane (C)",
    hint: c"Depth that is in focus, as the depth has it, where Focus says so.",
    kind: Kind::Number {
        default: 0.0,
        range: (-1e9, 1e9),
        slider: (0.0, 10.0),
        digits: 5,
    },
};

pub(crate) static POINT: Knob = Knob {
    name: c"focalPoint",
    label: c"Focal Point",
    hint: c"Move it to focus on what is there: sets Focus Plane (C) to the depth under it.",
    kind: Kind::Pair {
        default: (200.0, 200.0),
        position: true,
    },
};

pub(crate) static DEPTH_OF_FIELD: Knob = Knob {
    name: c"dof",
    label: c"Depth of Field",
    hint: c"Metres about the focus plane in which all is as sharp as on it.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 1e6),
        slider: (0.0, 10.0),
        digits: 3,
    },
};

pub(crate) static FRONT: Knob = Knob {
    name: c"front",
    label: c"Front Multiplier",
    hint: c"How many times as fast blur grows before the focus plane.",
    kind: Kind::Number {
        default: 1.0,
        range: (0.0, 100.0),
        slider: (0.0, 2.0),
        digits: 3,
    },
};

pub(crate) static BACK: Knob = Knob {
    name: c"back",
    label: c"Back Multiplier",
    hint: c"How many times as fast blur grows behind the focus plane.",
    kind: Kind::Number {
        default: 1.0,
        range: (0.0, 100.0),
        slider: (0.0, 2.0),
        digits: 3,
    },
};

pub(crate) static MAX_SIZE: Knob = Knob {
    name: c"maxSize",
    label: c"Maximum",
    hint: c"Largest blur: the radius of an even disc, pixels at full resolution. 0: none.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 10000.0),
        slider: (0.0, 256.0),
        digits: 1,
    },
};

pub(crate) static GROUP: Group = Group {
    name: c"focusGroup",
    label: c"Focus",
    open: true,
    knobs: &[
        &FOCUS,
        &DISTANCE,
        &PLANE,
        &POINT,
        &DEPTH_OF_FIELD,
        &FRONT,
        &BACK,
        &MAX_SIZE,
    ],
};
