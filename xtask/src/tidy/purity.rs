//! What is never where: no files or clocks in core, no unsafe outside the FFI layer.

use super::Tree;

/// Doors to the world that core has not.
const DOORS: [&str; 7] = [
    "std::fs",
    "std::env",
    "std::net",
    "std::time",
    "std::process",
    "println!",
    "thread_local!",
];

/// Rooms that the cases of `core/src/trial` are to test, and so share nothing with.
const ON_TRIAL: [&str; 10] = [
    "lens", "psf", "effects", "fit", "predict", "profile", "moments", "eval", "render", "diagnose",
];

/// Cases made by the model that they test would prove nothing.
fn trial(tree: &Tree, problems: &mut Vec<String>) {
    for (path, text) in tree.each(|p| p.starts_with("core/src/trial/") && p.ends_with(".rs")) {
        for room in ON_TRIAL {
            for door in ["crate::", "seidel_core::", "super::super::"] {
                let name = [door, room].concat();
                let goes_on = |c: char| c.is_alphanumeric() || c == '_';
                let named = text
                    .match_indices(name.as_str())
                    .any(|(at, _)| !text[at + name.len()..].starts_with(goes_on));
                if named {
                    problems.push(format!(
                        "{path}: what puts the model on trial must not use {name}"
                    ));
                }
            }
        }
        if text.contains("use crate::{") {
            problems.push(format!(
                "{path}: name each room of core in a `use` of its own"
            ));
        }
    }
}

pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    trial(tree, problems);
    for (path, text) in tree.each(|p| p.starts_with("core/src/") && p.ends_with(".rs")) {
        for door in DOORS {
            if text.contains(door) {
                problems.push(format!("{path}: core must not use {door}"));
            }
        }
    }
    for path in [
        "core/src/lib.rs",
        "cli/src/lib.rs",
        "cli/image-io/src/lib.rs",
        "colour/src/lib.rs",
    ] {
        let text = tree.text(path);
        if !text.is_empty() && !text.contains("#![forbid(unsafe_code)]") {
            problems.push(format!("{path}: must forbid unsafe code"));
        }
    }
    let outside_files = |p: &str| {
        p.starts_with("cli/src/") && p.ends_with(".rs") && !p.starts_with("cli/src/files")
    };
    for (path, text) in tree.each(outside_files) {
        if text.contains("File::open") || text.contains("fs::read") || text.contains("fs::write") {
            problems.push(format!(
                "{path}: files are opened in cli/image-io and cli/src/files only"
            ));
        }
    }
}
