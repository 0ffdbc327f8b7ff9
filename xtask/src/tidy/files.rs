//! Rules for single files: their size, their first line, their contents, and documents that must agree.

use crate::workspace::{Package, Tree};

/// Largest number of lines of a Rust file. A longer one usually holds two subjects.
const MAX_LINES: usize = 600;

pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    for file in tree.rust_files("") {
        let path = &file.path;
        let lines = file.text.lines().count();
        if lines > MAX_LINES {
            problems.push(format!("{path}: {lines} lines, over {MAX_LINES}; split it"));
        }
        if !file.text.starts_with("//!") && !file.text.starts_with("#!") {
            problems.push(format!("{path}: does not begin with a `//!` comment"));
        }
    }
    check_machine_paths(tree, problems);
    check_commands(tree, problems);
    check_changelog(tree, problems);
}

fn check_machine_paths(tree: &Tree, problems: &mut Vec<String>) {
    // In parts, so that this file does not match itself.
    let starts = ["work", "home", "root"].map(|folder| ["/", folder, "/"].concat());
    for file in tree
        .files()
        .filter(|file| !file.path.ends_with("Cargo.lock"))
    {
        for start in &starts {
            if file.text.contains(start) {
                problems.push(format!(
                    "{}: contains a path of one machine ({start})",
                    file.path
                ));
            }
        }
    }
}

/// CI runs the test command that the README gives.
fn check_commands(tree: &Tree, problems: &mut Vec<String>) {
    let test = "cargo test --workspace";
    let demo = "cargo run --release -- demo";
    for (path, command) in [("README.md", test), ("README.md", demo), (".ci/run", test)] {
        if !tree.text(path).contains(command) {
            problems.push(format!("{path}: lacks the command `{command}`"));
        }
    }
}

fn check_changelog(tree: &Tree, problems: &mut Vec<String>) {
    let mut lines = tree.text("Cargo.toml").lines();
    let version = lines.find_map(|line| line.strip_prefix("version = "));
    let version = version.unwrap_or("").trim_matches('"');
    if !tree.text("CHANGELOG.md").contains(&format!("[{version}]")) {
        problems.push(format!("CHANGELOG.md: has no entry for version {version}"));
    }
}

/// ARCHITECTURE.md names every package.
pub(super) fn check_map(tree: &Tree, packages: &[Package], problems: &mut Vec<String>) {
    let map = tree.text("ARCHITECTURE.md");
    for Package { name, folder, .. } in packages {
        if !map.is_empty() && !map.contains(name.as_str()) {
            problems.push(format!("ARCHITECTURE.md: does not name {name} ({folder})"));
        }
    }
}
