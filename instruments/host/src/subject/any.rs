//! An unknown plugin, which is tested with its defaults.

use super::PluginKind;

pub(super) static KIND: PluginKind = PluginKind {
    name: "any",
    blur: &[],
    identities: &[],
    variants: &[],
    connected_variants: &[],
    depth: None,
    mask: None,
    file: None,
    references: &[],
    animated: None,
    half_scale_tolerance: 1.0,
    pixel_aspect_tolerance: f64::INFINITY,
    polls_abort: false,
};
