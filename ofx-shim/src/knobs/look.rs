//! The look group: iris, squeeze, obstruction, aberrations and bloom.

use seidel_core::{Blades, HostGroup};

use super::{Group, Kind, Knob, Own};

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

pub(crate) static USE_APERTURE: Knob = Knob {
    name: c"useAperture",
    label: c"Use Aperture",
    hint: c"Discs show the picture of the input Aperture: white where light passes, its shorter side as wide as the pupil.",
    kind: Kind::Switch(false),
};

pub(crate) static GROUP: Group = Group {
    name: c"lookGroup",
    label: c"Look",
    open: false,
    own: &[Own::first(&BLADES), Own::after("rotation", &USE_APERTURE)],
    table: Some(HostGroup::Look),
};
