//! The output group: what is rendered, mask and mix.

use super::{Group, Kind, Knob, Own, Rows};

/// Output: the blurred, sharpened or relensed plate.
pub(crate) const RESULT: i32 = 0;
/// Output: the focal plane setup.
pub(crate) const FOCAL_PLANE: i32 = 1;
/// Output: the confidence of a removal.
pub(crate) const CONFIDENCE: i32 = 2;
/// Output: the noise gain of a removal.
pub(crate) const NOISE_GAIN: i32 = 3;
/// Output: PSFs over the frame.
pub(crate) const PSF_GRID: i32 = 4;
/// Output: circles of confusion in false colour.
pub(crate) const COC_MAP: i32 = 5;
/// Output: the gap between the result and a photograph.
pub(crate) const GAP: i32 = 6;

pub(crate) static OUTPUT: Knob = Knob {
    name: c"output",
    label: c"Output",
    hint: c"Focal Plane Setup: orange is nearer than the focus, white in focus, blue farther. Confidence (Remove): share of spatial frequencies that the plate determines, 0 to 1. Noise Gain (Remove): noise of the result over noise of the plate. PSF Grid: points of light over the frame at the depth there, each scaled to its own peak. CoC Map: diameter of the circle of confusion in pixels, 0 black, 1 violet, 2 indigo, 4 blue, 8 teal, 16 sea green, 32 green, 64 lime, 128 yellow. Gap: where the result and the photograph of input Reference differ, in blocks of 16 pixels: 0 is equal, 1 is as different as a flat picture; exposure is no difference, noise is.",
    kind: Kind::Choice {
        default: RESULT,
        options: &[
            c"Result",
            c"Focal Plane Setup",
            c"Confidence",
            c"Noise Gain",
            c"PSF Grid",
            c"CoC Map",
            c"Gap",
        ],
    },
};

/// Channels: colours and alpha.
pub(crate) const ALL_CHANNELS: i32 = 0;
/// Channels: the colours alone.
pub(crate) const COLOURS: i32 = 1;
/// Channels: alpha alone.
pub(crate) const ALPHA: i32 = 2;

pub(crate) static CHANNELS: Knob = Knob {
    name: c"channels",
    label: c"Channels",
    hint: c"Channels that Result has; the others stay those of the source. A source of alpha alone follows RGBA and Alpha.",
    kind: Kind::Choice {
        default: ALL_CHANNELS,
        options: &[c"RGBA", c"RGB", c"Alpha"],
    },
};

pub(crate) static USE_MASK: Knob = Knob {
    name: c"useMask",
    label: c"Use Mask",
    hint: c"Keeps the source where the alpha of the input Mask is 0, if it is connected, or scales the blur: see Mask Scales. Some hosts, such as Resolve, always report it as connected: there, switch this on only if it is.",
    kind: Kind::Switch(true),
};

pub(crate) static MASK_INVERT: Knob = Knob {
    name: c"maskInvert",
    label: c"Invert Mask",
    hint: c"Uses 1 less the mask.",
    kind: Kind::Switch(false),
};

/// Mask Scales: the weight of the result.
pub(crate) const SCALES_MIX: i32 = 0;
/// Mask Scales: the blur of each pixel.
pub(crate) const SCALES_BLUR: i32 = 1;

pub(crate) static MASK_SCALES: Knob = Knob {
    name: c"maskScales",
    label: c"Mask Scales",
    hint: c"Mix: the mask is the weight of the result against the source. Blur (mode Apply): the mask is a factor of the blur of each pixel, 0 as sharp as in focus, without a blurred copy around it.",
    kind: Kind::Choice {
        default: SCALES_MIX,
        options: &[c"Mix", c"Blur"],
    },
};

pub(crate) static MIX: Knob = Knob {
    name: c"mix",
    label: c"Mix",
    hint: c"Weight of the result against the source, 0 to 1.",
    kind: Kind::Number {
        default: 1.0,
        range: (0.0, 1.0),
        slider: (0.0, 1.0),
        digits: 3,
    },
};

pub(crate) static SHOW_LENS: Knob = Knob {
    name: c"showLens",
    label: c"Show Lens",
    hint: c"Shows PSF outlines at Distance and the optical axis in the viewer. Only in hosts that support the OpenFX draw suite.",
    kind: Kind::Switch(true),
};

pub(crate) static GROUP: Group = Group {
    name: c"outputGroup",
    label: c"Output",
    open: true,
    own: &[
        Own::first(&OUTPUT),
        Own::first(&CHANNELS),
        Own::first(&USE_MASK),
        Own::first(&MASK_INVERT),
        Own::first(&MASK_SCALES),
        Own::first(&MIX),
        Own::first(&SHOW_LENS),
    ],
    table: Rows::None,
};
