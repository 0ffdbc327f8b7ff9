//! Seidel's own plugin.

use super::{Animated, FileParameter, PluginKind, StaticValue};

// A built-in lens, scaled down and at a short distance, gives a blur of a few pixels that differs between channels.
pub(super) static KIND: PluginKind = PluginKind {
    name: "seidel",
    blur: &[
        ("mode", StaticValue::Int(0)),
        ("lens", StaticValue::Int(1)),
        ("lensScale", StaticValue::Double(0.25)),
        ("distance", StaticValue::Double(1.0)),
        ("math", StaticValue::Int(1)),
        ("maxSize", StaticValue::Double(6.0)),
    ],
    identities: &[
        &[("amount", StaticValue::Double(0.0))],
        &[("mix", StaticValue::Double(0.0))],
    ],
    variants: &[
        &[("mode", StaticValue::Int(1))],
        &[("mode", StaticValue::Int(2))],
        &[
            ("mode", StaticValue::Int(1)),
            ("onlyChroma", StaticValue::Int(1)),
        ],
        &[
            ("mode", StaticValue::Int(1)),
            ("output", StaticValue::Int(2)),
        ],
        &[
            ("mode", StaticValue::Int(1)),
            ("output", StaticValue::Int(3)),
        ],
        &[("output", StaticValue::Int(1))],
        &[("output", StaticValue::Int(4))],
        &[("output", StaticValue::Int(5))],
        &[
            ("quality", StaticValue::Int(0)),
            ("channels", StaticValue::Int(1)),
        ],
        &[("quality", StaticValue::Int(2))],
        &[
            ("edge", StaticValue::Int(1)),
            ("geometry", StaticValue::Int(2)),
        ],
        // Holdouts work with occlusion only.
        &[
            ("occlusion", StaticValue::Int(0)),
            ("useHoldout", StaticValue::Int(0)),
            ("mix", StaticValue::Double(0.5)),
        ],
    ],
    connected_variants: &[&[("output", StaticValue::Int(6))]],
    depth: Some(&[("useDepth", StaticValue::Int(1))]),
    mask: Some(&[("useMask", StaticValue::Int(1))]),
    file: Some(FileParameter {
        name: "profile",
        in_use: &[("lens", StaticValue::Int(0))],
        not_in_use: &[
            ("lens", StaticValue::Int(1)),
            ("profile", StaticValue::Text("")),
        ],
    }),
    references: &[
        &[
            ("lens", StaticValue::Int(0)),
            ("profile", StaticValue::Text("library:macro-100")),
        ],
        &[
            ("sourceCodes", StaticValue::Int(13)),
            ("ocioConfig", StaticValue::Text("seidel")),
            ("sourceSpace", StaticValue::Text("srgb_rec709_scene")),
        ],
    ],
    animated: Some(Animated {
        name: "focusDistance",
        range: (1.2, 3.0),
        in_use: &[("focus", StaticValue::Int(1))],
    }),
    half_scale_tolerance: 0.12,
    pixel_aspect_tolerance: 0.12,
    polls_abort: false,
};
