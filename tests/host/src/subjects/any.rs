//! A plugin that nothing is known of.

use crate::subject::Kind;

/// Defaults are all it is tried with.
pub static KIND: Kind = Kind {
    name: "any",
    blur: &[],
    identities: &[],
    variants: &[],
    depth: None,
    mask: None,
    file: None,
    half_scale: 1.0,
    half_width: f64::INFINITY,
    polls: false,
};
