//! The render group: quality, edges, occlusion, holdout and alpha.

use seidel_core::HostGroup;

use super::{Group, Kind, Knob, Own, Rows};

pub(crate) static AUTO_DRAFT: Knob = Knob {
    name: c"autoDraft",
    label: c"Draft While Editing",
    hint: c"Renders in draft quality if the host requests a draft or a thumbnail.",
    kind: Kind::Switch(true),
};

pub(crate) static USE_HOLDOUT: Knob = Knob {
    name: c"useHoldout",
    label: c"Use Holdout",
    hint: c"Holds out the element of the input Holdout, if it is connected: its matte removes the light behind it, without blur, because the element is composited in front later. Some hosts, such as Resolve, always report it as connected: there, switch this on only if it is. Needs Occlusion.",
    kind: Kind::Switch(true),
};

pub(crate) static HOLDOUT_CHANNEL: Knob = Knob {
    name: c"holdoutChannel",
    label: c"Holdout Matte",
    hint: c"Channel of the input Holdout that holds the matte.",
    kind: Kind::Choice {
        default: 3,
        options: &[c"R", c"G", c"B", c"A"],
    },
};

pub(crate) static HOLDOUT_DEPTH: Knob = Knob {
    name: c"holdoutDepth",
    label: c"Holdout Depth",
    hint: c"Channel of the input Holdout that holds its depth, in the convention of the plate's: only light from behind it is held out. None: all light is.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"None", c"R", c"G", c"B", c"A"],
    },
};

pub(crate) static SOURCE_ALPHA: Knob = Knob {
    name: c"sourceAlpha",
    label: c"Source Alpha",
    hint:
        c"Premultiplication of the source: as the host reports it, or set here if the report is wrong.",
    kind: Kind::Choice {
        default: 0,
        options: &[c"From Host", c"Premultiplied", c"Unpremultiplied"],
    },
};

pub(crate) static SCRUB: Knob = Knob {
    name: c"scrub",
    label: c"Scrub",
    hint: c"Treats samples that are not finite as zero. Otherwise they are an error.",
    kind: Kind::Switch(false),
};

pub(crate) static GROUP: Group = Group {
    name: c"renderGroup",
    label: c"Render",
    open: false,
    own: &[
        Own::after("quality", &AUTO_DRAFT),
        Own::after("blur-inside", &USE_HOLDOUT),
        Own::after("blur-inside", &HOLDOUT_CHANNEL),
        Own::after("blur-inside", &HOLDOUT_DEPTH),
        Own::after("blur-inside", &SOURCE_ALPHA),
        Own::after("blur-inside", &SCRUB),
    ],
    table: Rows::Of(HostGroup::Render),
};
