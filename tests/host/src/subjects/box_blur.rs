//! The box blur of `tests/broken-plugin`.

use crate::subject::{FileKnob, Kind, Knob};

/// `size` is the radius in canonical pixels; `mix` 0 and `size` 0 change nothing.
pub static KIND: Kind = Kind {
    name: "box",
    blur: &[("size", Knob::Double(4.0))],
    identities: &[
        &[("size", Knob::Double(0.0))],
        &[("mix", Knob::Double(0.0))],
    ],
    variants: &[
        &[("size", Knob::Double(0.4))],
        &[("mix", Knob::Double(0.3)), ("useDepth", Knob::Int(1))],
        &[("size", Knob::Double(24.0)), ("useMask", Knob::Int(1))],
    ],
    depth: Some(&[("useDepth", Knob::Int(1))]),
    mask: Some(&[("useMask", Knob::Int(1))]),
    file: Some(FileKnob {
        name: "file",
        in_use: &[],
        without: &[("file", Knob::Text(""))],
    }),
    half_scale: 0.12,
    half_width: 0.12,
    polls: true,
};
