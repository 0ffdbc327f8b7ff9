//! The look group: iris, squeeze, obstruction, aberrations and bloom.

use std::ffi::CStr;

use seidel_core::{Blades, Bloom, Look, LookRange};

use super::{Group, Kind, Knob};

/// Blades: those of the lens.
pub(crate) const OF_LENS: i32 = 0;
/// Blades: a round iris.
pub(crate) const ROUND: i32 = 1;
/// Blades: index of three blades in the menu; more follow.
const THREE: i32 = 2;

/// Returns the number of blades at `index` of the menu, 0 for a round iris; `None` for those of the lens.
pub(crate) fn blade_count(index: i32) -> Option<u32> {
    match index {
        OF_LENS => None,
        ROUND => Some(0),
        _ => Some((index - THREE) as u32 + Blades::COUNTS.0),
    }
}

pub(crate) static BLADES: Knob = Knob {
    name: c"blades",
    label: c"Blades",
    hint: c"Number of iris blades: discs are polygons. Looks need a lens of rays: one that comes with Seidel, or one fitted with --model reduced. They act on the lens as F Stop and Focus set it.",
    kind: Kind::Choice {
        default: OF_LENS,
        options: &[
            c"As Lens", c"Round", c"3", c"4", c"5", c"6", c"7", c"8", c"9", c"10", c"11", c"12",
            c"13",
        ],
    },
};

/// A number of a look, whose slider spans its `range`.
const fn number(
    name: &'static CStr,
    label: &'static CStr,
    hint: &'static CStr,
    range: LookRange,
    digits: i32,
) -> Knob {
    Knob {
        name,
        label,
        hint,
        kind: Kind::Number {
            default: range.neutral,
            range: (range.least, range.most),
            slider: (range.least, range.most),
            digits,
        },
    }
}

pub(crate) static ROUNDNESS: Knob = number(
    c"roundness",
    c"Roundness",
    c"Curvature of the blades: 0 straight, 1 one circle.",
    Blades::ROUNDNESS,
    2,
);

pub(crate) static ROTATION: Knob = number(
    c"rotation",
    c"Rotation",
    c"Direction of one corner of discs before the focus, in degrees from right towards down. Behind the focus they are turned by 180 degrees.",
    Blades::ROTATION_DEG,
    1,
);

pub(crate) static USE_APERTURE: Knob = Knob {
    name: c"useAperture",
    label: c"Use Aperture",
    hint: c"Discs show the picture of the input Aperture: white where light passes, its shorter side as wide as the pupil.",
    kind: Kind::Switch(false),
};

pub(crate) static SQUEEZE: Knob = number(
    c"squeeze",
    c"Squeeze",
    c"Height of discs over their width, times that of the lens: 2 for the ovals of a 2x anamorphic lens.",
    Look::SQUEEZE,
    3,
);

pub(crate) static OBSTRUCTION: Knob = number(
    c"obstruction",
    c"Obstruction",
    c"Radius of the dark middle of discs over theirs, as of a mirror lens. 0: as the lens.",
    Look::OBSTRUCTION,
    2,
);

pub(crate) static CATS_EYE: Knob = number(
    c"catsEye",
    c"Cat's Eye",
    c"Clipping of discs towards the corners: -1 none, 0 as the lens, 1 strong.",
    Look::CATS_EYE,
    2,
);

pub(crate) static SPHERICAL: Knob = number(
    c"spherical",
    c"Soft or Bubble",
    c"Spherical aberration added to that of the lens: -1 soft discs behind the focus, 1 bubbles with bright rims. Before the focus it is the other way round.",
    Look::SPHERICAL,
    2,
);

pub(crate) static AXIAL_COLOUR: Knob = number(
    c"axialColour",
    c"Axial Colour",
    c"Factor on the difference of focus between channels: 0 none, 1 as the lens.",
    Look::COLOUR,
    2,
);

pub(crate) static LATERAL_COLOUR: Knob = number(
    c"lateralColour",
    c"Lateral Colour",
    c"Factor on the difference of magnification between channels: 0 none, 1 as the lens. Geometry None leaves it out.",
    Look::COLOUR,
    2,
);

pub(crate) static BLOOM: Knob = number(
    c"bloom",
    c"Bloom",
    c"Share of the light above Bloom Level that spreads around highlights. For any lens.",
    LookRange {
        least: 0.0,
        most: 1.0,
        neutral: 0.0,
    },
    3,
);

pub(crate) static BLOOM_LEVEL: Knob = Knob {
    name: c"bloomLevel",
    label: c"Bloom Level",
    hint: c"Scene-linear value above which light spreads.",
    kind: Kind::Number {
        default: 1.0,
        range: (0.0, 1e6),
        slider: (0.0, 10.0),
        digits: 3,
    },
};

pub(crate) static BLOOM_RADIUS: Knob = Knob {
    name: c"bloomRadius",
    label: c"Bloom Radius",
    hint:
        c"Radius that holds half of the spread light, in per cent of the width of the lens's frame.",
    kind: Kind::Number {
        default: 1.0,
        range: (100.0 * Bloom::RADII.0, 100.0 * Bloom::RADII.1),
        slider: (100.0 * Bloom::RADII.0, 5.0),
        digits: 2,
    },
};

pub(crate) static GROUP: Group = Group {
    name: c"lookGroup",
    label: c"Look",
    open: false,
    knobs: &[
        &BLADES,
        &ROUNDNESS,
        &ROTATION,
        &USE_APERTURE,
        &SQUEEZE,
        &OBSTRUCTION,
        &CATS_EYE,
        &SPHERICAL,
        &AXIAL_COLOUR,
        &LATERAL_COLOUR,
        &BLOOM,
        &BLOOM_LEVEL,
        &BLOOM_RADIUS,
    ],
};
