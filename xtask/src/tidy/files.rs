//! Size of files, words that do not belong in them, and documents that must agree.

use super::Tree;

/// Rust files longer than this hold two things.
const MOST_LINES: usize = 600;

pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    for (path, text) in tree.each(|p| p.ends_with(".rs")) {
        let lines = text.lines().count();
        if lines > MOST_LINES {
            problems.push(format!(
                "{path}: {lines} lines, over {MOST_LINES}; split it"
            ));
        }
        let documented = text.starts_with("//!") || text.starts_with("#!");
        if !documented {
            problems.push(format!("{path}: does not begin by saying what it holds"));
        }
    }
    // Written apart, so that this file does not find itself.
    let homes = [
        ["/", "work/"].concat(),
        ["/", "home/"].concat(),
        ["/", "root/"].concat(),
    ];
    for (path, text) in tree.each(|p| p != "Cargo.lock") {
        for home in &homes {
            if text.contains(home.as_str()) {
                problems.push(format!("{path}: names a path of one machine ({home})"));
            }
        }
    }
    readme_and_ci(tree, problems);
}

/// CI runs what the README tells newcomers to run.
fn readme_and_ci(tree: &Tree, problems: &mut Vec<String>) {
    let test = "cargo test --workspace";
    let run = "cargo run --release -- demo";
    for (path, command) in [("README.md", test), ("README.md", run), (".ci/run", test)] {
        if !tree.text(path).contains(command) {
            problems.push(format!("{path}: lacks the command `{command}`"));
        }
    }
    let version = tree
        .text("Cargo.toml")
        .lines()
        .find_map(|line| line.strip_prefix("version = "))
        .unwrap_or("")
        .trim_matches('"')
        .to_owned();
    if !tree.text("CHANGELOG.md").contains(&format!("[{version}]")) {
        problems.push(format!("CHANGELOG.md: has no entry for version {version}"));
    }
    let map = tree.text("ARCHITECTURE.md");
    for folder in [
        "core", "cli", "colour", "plugin", "ofx-shim", "tests", "luts", "xtask",
    ] {
        if !map.contains(&format!("`{folder}/")) && !map.contains(&format!("`{folder}`")) {
            problems.push(format!("ARCHITECTURE.md: does not name `{folder}`"));
        }
    }
}
