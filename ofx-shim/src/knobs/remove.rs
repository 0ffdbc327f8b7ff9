//! The remove group: noise, clipping and strength of a removal.

use seidel_core::HostGroup;

use super::{Group, Kind, Knob, Own, Rows};

pub(crate) static ONLY_CHROMA: Knob = Knob {
    name: c"onlyChroma",
    label: c"Only Chroma",
    hint: c"Remove: takes lateral and axial colour off, and sharpens nothing else: every colour gets the blur of the colour whose blur is of middle size. Apply: the lens's lateral and axial colour alone; the sharpest colour stays sharp.",
    kind: Kind::Switch(false),
};

pub(crate) static CHECK_LENS: Knob = Knob {
    name: c"checkLens",
    label: c"Check Lens",
    hint: c"Remove and Relens: compares the blur of this frame with the lens's. If the frame shows less, Amount is reduced to match, which avoids ringing. Takes at least as long as a removal.",
    kind: Kind::Button,
};

pub(crate) static GROUP: Group = Group {
    name: c"removeGroup",
    label: c"Remove",
    open: false,
    own: &[
        Own::after("strength", &ONLY_CHROMA),
        Own::after("clip-level", &CHECK_LENS),
    ],
    table: Rows::Of(HostGroup::Remove),
};
