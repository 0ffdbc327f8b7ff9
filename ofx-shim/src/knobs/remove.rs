//! How blur is taken off.

use super::{Group, Kind, Knob};

pub(crate) static STRENGTH: Knob = Knob {
    name: c"strength",
    label: c"Strength",
    hint: c"Remove: how much of the way from the plate to the sharp picture to go.",
    kind: Kind::Number {
        default: 1.0,
        range: (0.0, 1.0),
        slider: (0.0, 1.0),
        digits: 3,
    },
};

pub(crate) static GRAIN: Knob = Knob {
    name: c"grain",
    label: c"Grain",
    hint: c"Remove. Keep: the sharp picture gets the plate's own grain. Solved: it stays as it was solved for, nearly without grain.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"Keep", c"Solved"],
    },
};

pub(crate) static NOISE: Knob = Knob {
    name: c"noise",
    label: c"Noise",
    hint:
        c"Remove and Relens: standard deviation of the plate's noise. 0: estimated from the plate.",
    kind: Kind::Number {
        default: 0.0,
        range: (0.0, 1000.0),
        slider: (0.0, 0.1),
        digits: 5,
    },
};

pub(crate) static CLIP: Knob = Knob {
    name: c"clip",
    label: c"Clipping",
    hint: c"Remove and Relens: where the plate is clipped is told from it; or it is not; or it is from Clip Level on.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"Told", c"None", c"Level"],
    },
};

pub(crate) static CLIP_LEVEL: Knob = Knob {
    name: c"clipLevel",
    label: c"Clip Level",
    hint: c"Where samples are clipped, where Clipping says Level.",
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
    hint: c"Remove and Relens: looks whether this frame shows as much blur as the lens has. Where it shows less, Amount becomes as much, so that nothing rings. The time of a removal or more.",
    kind: Kind::Button,
};

pub(crate) static GROUP: Group = Group {
    name: c"removeGroup",
    label: c"Remove",
    open: false,
    knobs: &[&STRENGTH, &GRAIN, &NOISE, &CLIP, &CLIP_LEVEL, &CHECK_LENS],
};
