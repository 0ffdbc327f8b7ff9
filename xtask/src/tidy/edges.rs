//! Which crate may depend on which, and what every package states.

use super::Tree;

/// What each crate may use of the others outside its tests.
const ALLOWED: [(&str, &[&str]); 10] = [
    ("core", &[]),
    ("colour", &[]),
    ("plugin", &["seidel-core"]),
    // The host is what it is tested with.
    (
        "ofx-shim",
        &["seidel-colour", "seidel-plugin", "seidel-ofx-host"],
    ),
    ("cli", &["seidel-colour", "seidel-core", "seidel-image-io"]),
    ("cli/image-io", &["seidel-core"]),
    (
        "tests",
        &[
            "seidel",
            "seidel-colour",
            "seidel-core",
            "seidel-image-io",
            "seidel-ofx",
            "seidel-ofx-host",
            "seidel-plugin",
        ],
    ),
    // It must share nothing with the plugins that it tests.
    ("tests/host", &[]),
    ("tests/broken-plugin", &["seidel-ofx-host"]),
    // Its curves, of which it makes files.
    ("xtask", &["seidel-colour"]),
];

const OURS: [&str; 9] = [
    "seidel",
    "seidel-colour",
    "seidel-core",
    "seidel-image-io",
    "seidel-ofx",
    "seidel-ofx-broken",
    "seidel-ofx-host",
    "seidel-plugin",
    "seidel-tests",
];

pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    for (folder, allowed) in ALLOWED {
        let path = format!("{folder}/Cargo.toml");
        let text = tree.text(&path);
        let mut section = "";
        for line in text.lines() {
            if line.starts_with('[') {
                section = line.trim();
                continue;
            }
            if !section.ends_with("dependencies]") {
                continue;
            }
            let name = line.split(['.', ' ', '=']).next().unwrap_or("");
            if OURS.contains(&name) && !allowed.contains(&name) {
                problems.push(format!("{path}: {folder} must not depend on {name}"));
            }
        }
        for need in ["license.workspace = true", "[lints]\nworkspace = true"] {
            if !text.is_empty() && !text.contains(need) {
                problems.push(format!("{path}: lacks `{need}`"));
            }
        }
    }
    if tree.text("Cargo.lock").contains("git+") {
        problems.push("Cargo.lock: a dependency comes from a git repository".to_owned());
    }
}
