//! The render group: quality, edges, occlusion, holdout and alpha.

use super::{Group, Kind, Knob};

pub(crate) static QUALITY: Knob = Knob {
    name: c"quality",
    label: c"Quality",
    hint: c"Accuracy against the exact renderer, as PSNR. Draft: 45 dB, for previews. Final: 60 dB, 50 dB for lenses fitted ray by ray, for delivery. Exact: every pixel has its own kernel; slow.",
    kind: Kind::Choice {
        default: 1,
        options: &[c"Draft", c"Final", c"Exact"],
    },
};

pub(crate) static AUTO_DRAFT: Knob = Knob {
    name: c"autoDraft",
    label: c"Draft While Editing",
    hint: c"Renders in draft quality if the host requests a draft or a thumbnail.",
    kind: Kind::Switch(true),
};

pub(crate) static EDGES: Knob = Knob {
    name: c"edge",
    label: c"Edges",
    hint: c"Light beyond the edges of the plate: its mirror image, black, or the nearest pixel. Auto chooses by alpha: Mirror for full frames, Black for elements over nothing, Nearest for elements that the border cuts.",
    kind: Kind::Choice {
        default: 3,
        options: &[c"Mirror", c"Black", c"Nearest", c"Auto"],
    },
};

/// The options of [`EXPAND`].
pub(crate) const EXPAND_AUTO: i32 = 0;
/// As above.
pub(crate) const EXPAND_ON: i32 = 1;

pub(crate) static EXPAND: Knob = Knob {
    name: c"expand",
    label: c"Expand",
    hint: c"Grows the region of definition by the reach of the blur, so that an element keeps its blurred rim. Auto: on the sides of a source with alpha that lie within the project. With a depth input the reach is that of the distances at which the lens was measured.",
    kind: Kind::Choice {
        default: EXPAND_AUTO,
        options: &[c"Auto", c"On", c"Off"],
    },
};

pub(crate) static OCCLUSION: Knob = Knob {
    name: c"occlusion",
    label: c"Occlusion",
    hint: c"Near objects hide far ones where depth varies.",
    kind: Kind::Switch(true),
};

pub(crate) static FILL_FOREGROUND: Knob = Knob {
    name: c"fillForeground",
    label: c"Fill Foreground",
    hint: c"Fills the background that a blurred foreground uncovers from the background beside it.",
    kind: Kind::Switch(true),
};

pub(crate) static BLUR_INSIDE: Knob = Knob {
    name: c"blurInside",
    label: c"Blur Inward",
    hint: c"Lets the edge of a blurred foreground become transparent inside its outline too, as in a camera. Off: it only blurs outwards. This is not Blur Inside of ZDefocus.",
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
    knobs: &[
        &QUALITY,
        &AUTO_DRAFT,
        &EDGES,
        &EXPAND,
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
