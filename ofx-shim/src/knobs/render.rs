//! How plates are drawn.

use super::{Group, Kind, Knob};

pub(crate) static QUALITY: Knob = Knob {
    name: c"quality",
    label: c"Quality",
    hint: c"Draft: for looking, 45 dB from exact. Final: for delivery, 60 dB from exact, 50 dB for lenses known ray by ray. Exact: every pixel with its own kernel, slow.",
    kind: Kind::Choice {
        default: 1,
        options: &[c"Draft", c"Final", c"Exact"],
    },
};

pub(crate) static AUTO_DRAFT: Knob = Knob {
    name: c"autoDraft",
    label: c"Draft While Editing",
    hint: c"Renders in draft quality where the host says that a draft or a thumbnail is wanted.",
    kind: Kind::Switch(true),
};

pub(crate) static EDGES: Knob = Knob {
    name: c"edge",
    label: c"Edges",
    hint: c"What lies beyond the plate: its mirror image, nothing, or its nearest pixel.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"Mirror", c"Black", c"Nearest"],
    },
};

pub(crate) static OCCLUSION: Knob = Knob {
    name: c"occlusion",
    label: c"Occlusion",
    hint: c"Near things hide far ones where depth varies.",
    kind: Kind::Switch(true),
};

pub(crate) static FILL_FOREGROUND: Knob = Knob {
    name: c"fillForeground",
    label: c"Fill Foreground",
    hint: c"What a blurred foreground uncovers is filled with what is seen beside it.",
    kind: Kind::Switch(true),
};

pub(crate) static BLUR_INSIDE: Knob = Knob {
    name: c"blurInside",
    label: c"Blur Inside",
    hint: c"A blurred foreground becomes transparent within its own outline.",
    kind: Kind::Switch(true),
};

pub(crate) static USE_HOLDOUT: Knob = Knob {
    name: c"useHoldout",
    label: c"Use Holdout",
    hint: c"Keeps blur off what the input Holdout says will be in front, where it is connected. Some hosts, such as Resolve, cannot tell whether it is: switch it on there when it is. Needs Occlusion.",
    kind: Kind::Switch(true),
};

pub(crate) static HOLDOUT_CHANNEL: Knob = Knob {
    name: c"holdoutChannel",
    label: c"Holdout Matte",
    hint: c"Which channel of the input Holdout is the matte.",
    kind: Kind::Choice {
        default: 3,
        options: &[c"R", c"G", c"B", c"A"],
    },
};

pub(crate) static HOLDOUT_DEPTH: Knob = Knob {
    name: c"holdoutDepth",
    label: c"Holdout Depth",
    hint: c"Which channel of the input Holdout is its depth, read as that of the plate: only what is behind is kept back. None: all is.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"None", c"R", c"G", c"B", c"A"],
    },
};

pub(crate) static SOURCE_ALPHA: Knob = Knob {
    name: c"sourceAlpha",
    label: c"Source Alpha",
    hint:
        c"Whether colour is multiplied by alpha: as the host says, or otherwise where it is wrong.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"As Host Says", c"Premultiplied", c"Unpremultiplied"],
    },
};

pub(crate) static SCRUB: Knob = Knob {
    name: c"scrub",
    label: c"Scrub",
    hint: c"Samples that are not finite count as zero, instead of being refused.",
    kind: Kind::Switch(false),
};

pub(crate) static GROUP: Group = Group {
    name: c"renderGroup",
    label: c"Render",
    open: false,
    knobs: &[
        &QUALITY,
        &AUTO_DRAFT,
        &EDGES,
        &OCCLUSION,
        &FILL_FOREGROUND,
        &BLUR_INSIDE,
        &USE_HOLDOUT,
        &HOLDOUT_CHANNEL,
        &HOLDOUT_DEPTH,
        &SOURCE_ALPHA,
        &SCRUB,
    ],
};
