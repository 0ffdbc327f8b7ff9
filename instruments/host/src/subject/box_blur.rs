//! The box blur of `instruments/broken-plugin`.

use super::{Animated, FileParameter, PluginKind, StaticValue};

// `size` is the radius in canonical pixels.
pub(super) static KIND: PluginKind = PluginKind {
    name: "box",
    blur: &[("size", StaticValue::Double(4.0))],
    identities: &[
        &[("size", StaticValue::Double(0.0))],
        &[("mix", StaticValue::Double(0.0))],
    ],
    variants: &[
        &[("size", StaticValue::Double(0.4))],
        &[
            ("mix", StaticValue::Double(0.3)),
            ("useDepth", StaticValue::Int(1)),
        ],
        &[
            ("size", StaticValue::Double(24.0)),
            ("useMask", StaticValue::Int(1)),
        ],
    ],
    connected_variants: &[],
    depth: Some(&[("useDepth", StaticValue::Int(1))]),
    mask: Some(&[("useMask", StaticValue::Int(1))]),
    file: Some(FileParameter {
        name: "file",
        in_use: &[],
        not_in_use: &[("file", StaticValue::Text(""))],
    }),
    references: &[],
    animated: Some(Animated {
        name: "size",
        range: (1.0, 5.0),
        in_use: &[],
    }),
    half_scale_tolerance: 0.12,
    pixel_aspect_tolerance: 0.12,
    polls_abort: true,
};
