//! Where depth comes from, and what its numbers are.

use super::{Group, Kind, Knob};

pub(crate) static USE_DEPTH: Knob = Knob {
    name: c"useDepth",
    label: c"Use Depth",
    hint: c"Takes depth from the input Depth where it is connected. Some hosts, such as Resolve, cannot tell whether it is: switch it on there when it is.",
    kind: Kind::Switch(true),
};

pub(crate) static CHANNEL: Knob = Knob {
    name: c"depthChannel",
    label: c"Depth Channel",
    hint: c"Which channel of the input Depth is depth. Of inputs with one channel it is that one.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"R", c"G", c"B", c"A", c"Luminance"],
    },
};

/// Channel: mean of what the eye sees as brightness.
pub(crate) const LUMINANCE: i32 = 4;

pub(crate) static MATH: Knob = Knob {
    name: c"math",
    label: c"Depth Math",
    hint: c"What depth is. depth: distance along the axis. far=0: one over the distance. far=1: 0 at Near and 1 at infinity, as of OpenGL. direct: how much nearer than the focus plane, less Focus Plane (C), in 1/m. With a minus: the same counted backwards. linear: normalised distance between Near and Far.",
    kind: Kind::Choice {
        default: 2,
        options: &[
            c"direct",
            c"depth",
            c"far=0",
            c"far=1",
            c"-direct",
            c"-depth",
            c"far=-0",
            c"far=-1",
            c"linear, far=1",
            c"linear, far=0",
        ],
    },
};

pub(crate) static UNIT: Knob = Knob {
    name: c"worldScale",
    label: c"World Scale",
    hint: c"Unit of distance in the depth.",
    kind: Kind::Choice {
        default: 2,
        options: &[
            c"millimetres",
            c"centimetres",
            c"metres",
            c"inches",
            c"feet",
            c"kilometres",
        ],
    },
};

/// Metres of each unit of [`UNIT`].
pub(crate) const UNIT_METRES: [f64; 6] = [0.001, 0.01, 1.0, 0.0254, 0.3048, 1000.0];

pub(crate) static UNIT_MULTIPLIER: Knob = Knob {
    name: c"worldMultiplier",
    label: c"World Multiplier",
    hint: c"Units that make up one of the depth.",
    kind: Kind::Number {
        default: 1.0,
        range: (1e-9, 1e9),
        slider: (0.01, 100.0),
        digits: 4,
    },
};

pub(crate) static NEAR: Knob = Knob {
    name: c"near",
    label: c"Near",
    hint: c"Distance of the near end of far=1 and linear depth, in units of World Scale.",
    kind: Kind::Number {
        default: 1.0,
        range: (1e-9, 1e9),
        slider: (0.01, 100.0),
        digits: 3,
    },
};

pub(crate) static FAR: Knob = Knob {
    name: c"far",
    label: c"Far",
    hint: c"Distance of the far end of linear depth, in units of World Scale.",
    kind: Kind::Number {
        default: 100.0,
        range: (1e-9, 1e9),
        slider: (1.0, 1000.0),
        digits: 3,
    },
};

pub(crate) static DISTANCE: Knob = Knob {
    name: c"distance",
    label: c"Distance",
    hint: c"Distance of everything where no depth is used, metres. A million and more is infinity.",
    kind: Kind::Number {
        default: 10.0,
        range: (0.001, 1e6),
        slider: (0.1, 100.0),
        digits: 3,
    },
};

/// From here on distances in metres are infinity.
pub(crate) const ENDLESS: f64 = 1e6;

pub(crate) static RAY_FOCAL: Knob = Knob {
    name: c"alongRay",
    label: c"Along Ray Focal",
    hint: c"Where depth is along the ray from the camera: the camera's focal length in pixels at full resolution, half the width over the tangent of half the field of view. 0: depth is along the axis.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 1e7),
        slider: (0.0, 10000.0),
        digits: 1,
    },
};

pub(crate) static GROUP: Group = Group {
    name: c"depthGroup",
    label: c"Depth",
    open: true,
    knobs: &[
        &USE_DEPTH,
        &CHANNEL,
        &MATH,
        &UNIT,
        &UNIT_MULTIPLIER,
        &NEAR,
        &FAR,
        &DISTANCE,
        &RAY_FOCAL,
    ],
};
