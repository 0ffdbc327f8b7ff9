//! Seidel's own plugin.

use crate::subject::{FileKnob, Kind, Knob};

/// A lens that comes with it, at half its frame's resolution, wide open and near: a blur of some pixels, the colours apart.
pub static KIND: Kind = Kind {
    name: "seidel",
    blur: &[
        ("mode", Knob::Int(0)),
        ("lens", Knob::Int(1)),
        ("lensScale", Knob::Double(0.25)),
        ("distance", Knob::Double(1.0)),
        ("math", Knob::Int(1)),
        ("maxSize", Knob::Double(6.0)),
    ],
    identities: &[
        &[("amount", Knob::Double(0.0))],
        &[("mix", Knob::Double(0.0))],
    ],
    variants: &[
        &[("mode", Knob::Int(1))],
        &[("mode", Knob::Int(2))],
        &[("mode", Knob::Int(1)), ("output", Knob::Int(2))],
        &[("mode", Knob::Int(1)), ("output", Knob::Int(3))],
        &[("output", Knob::Int(1))],
        &[("output", Knob::Int(4))],
        &[("quality", Knob::Int(0))],
        &[("quality", Knob::Int(2))],
        &[("edge", Knob::Int(1)), ("geometry", Knob::Int(2))],
        // Holdouts need occlusion.
        &[
            ("occlusion", Knob::Int(0)),
            ("useHoldout", Knob::Int(0)),
            ("mix", Knob::Double(0.5)),
        ],
    ],
    depth: Some(&[("useDepth", Knob::Int(1))]),
    mask: Some(&[("useMask", Knob::Int(1))]),
    file: Some(FileKnob {
        name: "profile",
        in_use: &[("lens", Knob::Int(0))],
        without: &[("lens", Knob::Int(1)), ("profile", Knob::Text(""))],
    }),
    half_scale: 0.12,
    half_width: 0.12,
    polls: false,
};
