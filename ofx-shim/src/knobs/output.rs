//! What comes out.

use super::{Group, Kind, Knob};

/// Output: the picture.
pub(crate) const RESULT: i32 = 0;
/// Output: where focus lies.
pub(crate) const FOCAL_PLANE: i32 = 1;
/// Output: how much of each pixel was seen and not guessed.
pub(crate) const CONFIDENCE: i32 = 2;
/// Output: how much stronger noise is.
pub(crate) const NOISE_GAIN: i32 = 3;
/// Output: how the lens draws points.
pub(crate) const PSF_GRID: i32 = 4;

pub(crate) static OUTPUT: Knob = Knob {
    name: c"output",
    label: c"Output",
    hint: c"Result. Focal Plane Setup: red is nearer than focus, green in focus, blue farther. Confidence: Remove, how much of each pixel was seen and not guessed. Noise Gain: Remove, how many times its size in the plate noise has. PSF Grid: how the lens draws points of light over the frame, at the depth there is, each as bright as can be shown.",
    kind: Kind::Choice {
        default: RESULT,
        options: &[
            c"Result",
            c"Focal Plane Setup",
            c"Confidence",
            c"Noise Gain",
            c"PSF Grid",
        ],
    },
};

pub(crate) static USE_MASK: Knob = Knob {
    name: c"useMask",
    label: c"Use Mask",
    hint: c"Keeps the source where the alpha of the input Mask is 0, where it is connected. Some hosts, such as Resolve, cannot tell whether it is: switch it on there when it is.",
    kind: Kind::Switch(true),
};

pub(crate) static MASK_INVERT: Knob = Knob {
    name: c"maskInvert",
    label: c"Invert Mask",
    hint: c"Keeps the source where the mask is 1.",
    kind: Kind::Switch(false),
};

pub(crate) static MIX: Knob = Knob {
    name: c"mix",
    label: c"Mix",
    hint: c"How much of the result goes over the source.",
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
    hint: c"Draws over the viewer how the lens draws points at Distance, and where its axis is. In hosts with overlays that need no OpenGL.",
    kind: Kind::Switch(true),
};

pub(crate) static GROUP: Group = Group {
    name: c"outputGroup",
    label: c"Output",
    open: true,
    knobs: &[&OUTPUT, &USE_MASK, &MASK_INVERT, &MIX, &SHOW_LENS],
};
