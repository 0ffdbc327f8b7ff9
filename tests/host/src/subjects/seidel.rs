//! Seidel's own plugin.

use crate::subject::{Kind, Knob};

/// To be filled in with the knobs of the plugin.
pub static KIND: Kind = Kind {
    name: "seidel",
    blur: &[("mode", Knob::Int(0))],
    identities: &[&[("mix", Knob::Double(0.0))]],
    depth: Some(&[("useDepth", Knob::Int(1))]),
    mask: None,
    file: None,
    half_scale: 0.2,
    half_width: 0.2,
    polls: false,
};
