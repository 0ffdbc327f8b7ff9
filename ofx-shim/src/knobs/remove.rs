//! The remove group: noise, clipping and strength of a removal.

use super::{Group, Kind, Knob};

pub(crate) static STRENGTH: Knob = Knob {
    name: c"strength",
    label: c"Strength",
    hint: c"Remove: weight of the sharp image against the plate, 0 to 1.",
    kind: Kind::Number {
        default: 1.0,
        range: (0.0, 1.0),
        slider: (0.0, 1.0),
        digits: 3,
    },
};

pub(crate) static ONLY_CHROMA: Knob = Knob {
    name: c"onlyChroma",
    label: c"Only Chroma",
    hint: c"Remove: takes lateral and axial colour off, and sharpens nothing else: every colour gets the blur of the colour whose blur is of middle size.",
    kind: Kind::Switch(false),
};

pub(crate) static GRAIN: Knob = Knob {
    name: c"grain",
    label: c"Grain",
    hint: c"Remove. Keep: the sharp image gets the plate's own grain. Solved: the solution as it is, nearly without grain.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"Keep", c"Solved"],
    },
};

pub(crate) static NOISE: Knob = Knob {
    name: c"noise",
    label: c"Noise",
    hint:
        c"Remove and Relens: standard deviation of the plate's noise, in linear units. 0: estimated from the plate.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 1000.0),
        slider: (0.0, 0.1),
        digits: 5,
    },
};

/// Clipping: from a level on.
pub(crate) const CLIP_BY_LEVEL: i32 = 2;

pub(crate) static CLIP: Knob = Knob {
    name: c"clip",
    label: c"Clipping",
    hint: c"Remove and Relens: clipped samples keep their blur. Auto: the level is estimated from the plate. None: no sample is clipped. Level: samples at or above Clip Level.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"Auto", c"None", c"Level"],
    },
};

pub(crate) static CLIP_LEVEL: Knob = Knob {
    name: c"clipLevel",
    label: c"Clip Level",
    hint: c"Level from which on samples are clipped, if Clipping is Level.",
    kind: Kind::Number {
        default: 1.0,
        range: (1e-6, 1e6),
        slider: (0.5, 16.0),
        digits: 3,
    },
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
    knobs: &[
        &STRENGTH,
        &ONLY_CHROMA,
        &GRAIN,
        &NOISE,
        &CLIP,
        &CLIP_LEVEL,
        &CHECK_LENS,
    ],
};
