//! The depth group: the depth pass and its convention.

use super::{Group, Kind, Knob, Own, Rows};

pub(crate) static USE_DEPTH: Knob = Knob {
    name: c"useDepth",
    label: c"Use Depth",
    hint: c"Uses the input Depth if it is connected. Some hosts, such as Resolve, always report it as connected: there, switch this on only if it is.",
    kind: Kind::Switch(true),
};

pub(crate) static CHANNEL: Knob = Knob {
    name: c"depthChannel",
    label: c"Depth Channel",
    hint: c"Channel of the input Depth that holds depth. Ignored for inputs with one channel.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"R", c"G", c"B", c"A", c"Luminance"],
    },
};

/// Depth channel: luminance.
pub(crate) const LUMINANCE: i32 = 4;

/// Depth math: distance.
pub(crate) const MATH_DEPTH: i32 = 1;
/// Depth math: one over the distance.
pub(crate) const MATH_FAR_ZERO: i32 = 2;

pub(crate) static MATH: Knob = Knob {
    name: c"math",
    label: c"Depth Math",
    hint: c"Convention of the depth pass. depth: distance along the axis. far=0: 1 / distance. far=1: 0 at Near and 1 at infinity, as in OpenGL. direct: 1 / distance relative to the focus, in 1/m, where Focus Plane (C) is the value in focus. With a minus: the same, negated. linear: distance normalised between Near and Far.",
    kind: Kind::Choice {
        default: MATH_DEPTH,
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

/// Returns whether a choice of [`MATH`] has no unit of distance.
pub(crate) fn is_direct(choice: i32) -> bool {
    matches!(choice, 0 | 4)
}

/// Returns whether a choice of [`MATH`] depends on [`NEAR`].
pub(crate) fn has_near(choice: i32) -> bool {
    matches!(choice, 3 | 7) || has_far(choice)
}

/// Returns whether a choice of [`MATH`] depends on [`FAR`].
pub(crate) fn has_far(choice: i32) -> bool {
    matches!(choice, 8 | 9)
}

pub(crate) static UNIT: Knob = Knob {
    name: c"worldScale",
    label: c"World Scale",
    hint: c"Unit of distance in the depth pass.",
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

/// Metres in each unit of [`UNIT`].
pub(crate) const UNIT_METRES: [f64; 6] = [0.001, 0.01, 1.0, 0.0254, 0.3048, 1000.0];

pub(crate) static UNIT_MULTIPLIER: Knob = Knob {
    name: c"worldMultiplier",
    label: c"World Multiplier",
    hint: c"Number of these units in one unit of the depth pass.",
    kind: Kind::Number {
        default: 1.0,
        range: (1e-9, 1e9),
        slider: (0.1, 4.0),
        digits: 4,
    },
};

pub(crate) static NEAR: Knob = Knob {
    name: c"near",
    label: c"Near",
    hint: c"Near distance of far=1 and linear depth, in units of World Scale.",
    kind: Kind::Number {
        default: 1.0,
        range: (1e-9, 1e9),
        slider: (0.1, 4.0),
        digits: 3,
    },
};

pub(crate) static FAR: Knob = Knob {
    name: c"far",
    label: c"Far",
    hint: c"Far distance of linear depth, in units of World Scale.",
    kind: Kind::Number {
        default: 100.0,
        range: (1e-9, 1e9),
        slider: (1.0, 200.0),
        digits: 3,
    },
};

pub(crate) static DISTANCE: Knob = Knob {
    name: c"distance",
    label: c"Distance (m)",
    hint: c"Distance of the whole plate if no depth is used, in metres. A million or more is infinity.",
    kind: Kind::Number {
        default: 10.0,
        range: (0.001, 1e6),
        slider: (0.1, 30.0),
        digits: 3,
    },
};

/// Distance in metres from which on distances count as infinity.
pub(crate) const INFINITE_DISTANCE: f64 = 1e6;

pub(crate) static RAY_FOCAL: Knob = Knob {
    name: c"alongRay",
    label: c"Along Ray Focal (px)",
    hint: c"For depth along the ray from the camera: the focal length in pixels at full resolution, which is half the width over the tangent of half the field of view. 0: depth is along the axis.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 1e7),
        slider: (0.0, 10000.0),
        digits: 1,
    },
};

pub(crate) static FILTER: Knob = Knob {
    name: c"depthFilter",
    label: c"Depth Filter (px)",
    hint: c"For depth that is averaged at edges, by a filter or by motion over the shutter: its width in pixels at full resolution. Edges up to that wide are divided between their two sides. 0: depth has one sample a pixel.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 256.0),
        slider: (0.0, 64.0),
        digits: 1,
    },
};

pub(crate) static GROUP: Group = Group {
    name: c"depthGroup",
    label: c"Depth",
    open: true,
    own: &[
        Own::first(&USE_DEPTH),
        Own::first(&CHANNEL),
        Own::first(&MATH),
        Own::first(&UNIT),
        Own::first(&UNIT_MULTIPLIER),
        Own::first(&NEAR),
        Own::first(&FAR),
        Own::first(&DISTANCE),
        Own::first(&RAY_FOCAL),
        Own::first(&FILTER),
    ],
    table: Rows::None,
};
