//! The focus group: the focus plane, and the growth of blur before and behind it.

use seidel_core::HostGroup;

use super::{Group, Kind, Knob, Own, Rows};

/// Focus: as measured.
pub(crate) const AS_MEASURED: i32 = 0;
/// Focus: at a distance in metres.
pub(crate) const AT_DISTANCE: i32 = 1;
/// Focus: at a value of the depth pass.
pub(crate) const AT_DEPTH: i32 = 2;

pub(crate) static FOCUS: Knob = Knob {
    name: c"focus",
    label: c"Focus",
    hint: c"As Measured: the focus distance that Lens Data states, else that at which the lens was measured. Focus Distance: a distance in metres. Focus Plane (C): a value of the depth pass.",
    kind: Kind::Choice {
        default: AS_MEASURED,
        options: &[c"As Measured", c"Focus Distance", c"Focus Plane (C)"],
    },
};

pub(crate) static DISTANCE: Knob = Knob {
    name: c"focusDistance",
    label: c"Focus Distance (m)",
    hint:
        c"Distance in focus, in metres, if Focus is Focus Distance. A million or more is infinity.",
    kind: Kind::Number {
        default: 2.0,
        range: (0.001, 1e6),
        slider: (0.1, 10.0),
        digits: 3,
    },
};

pub(crate) static PLANE: Knob = Knob {
    name: c"focusPlane",
    label: c"Focus Plane (C)",
    hint: c"Value of the depth pass in focus, if Focus is Focus Plane (C). Also the value in focus of Depth Math direct.",
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
    hint: c"Drag it over the picture: Focus Plane (C) becomes the depth under it.",
    kind: Kind::Pair {
        default: (200.0, 200.0),
        position: true,
    },
};

pub(crate) static GROUP: Group = Group {
    name: c"focusGroup",
    label: c"Focus",
    open: true,
    own: &[
        Own::first(&FOCUS),
        Own::first(&DISTANCE),
        Own::first(&PLANE),
        Own::first(&POINT),
    ],
    table: Rows::Of(HostGroup::Focus),
};
