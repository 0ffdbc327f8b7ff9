//! Lists that must name everything in their folder.

use crate::workspace::{TextFile, Tree};

/// A folder with one implementation a file, all in a list `ALL` in its `mod.rs`.
struct Registry {
    /// The folder's name, wherever it is.
    folder: &'static str,
    /// Traits that its files implement.
    traits: &'static [&'static str],
}

const REGISTRIES: [Registry; 2] = [
    Registry {
        folder: "psf",
        traits: &["PsfModel", "MomentPsf"],
    },
    Registry {
        folder: "effects",
        traits: &["Effect"],
    },
];

pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    for registry in &REGISTRIES {
        check_registry(tree, registry, problems);
    }
    check_host_checks(tree, problems);
}

/// The `mod.rs` that holds the list, and the list.
pub(super) fn find_list<'a>(tree: &'a Tree, folder: &str) -> Option<(&'a TextFile, &'a str)> {
    let end = format!("/{folder}/mod.rs");
    tree.files().find_map(|file| {
        let (_, list) = file.text.split_once("pub static ALL")?;
        let list = list.split("];").next()?;
        file.path.ends_with(&end).then_some((file, list))
    })
}

fn check_registry(tree: &Tree, registry: &Registry, problems: &mut Vec<String>) {
    let name = registry.folder;
    let Some((file, list)) = find_list(tree, name) else {
        problems.push(format!("no file {name}/mod.rs has a `pub static ALL`"));
        return;
    };
    for part in tree.rust_files(file.path.trim_end_matches("mod.rs")) {
        for implementation in implementations(part, registry.traits) {
            if !list.contains(&format!("&{implementation},")) {
                problems.push(format!(
                    "{}: {implementation} is not in {name}::ALL",
                    part.path
                ));
            }
        }
    }
}

/// Types that a file implements one of `traits` for.
pub(super) fn implementations<'a>(
    file: &'a TextFile,
    traits: &'static [&'static str],
) -> impl Iterator<Item = &'a str> {
    file.text.lines().filter_map(|line| {
        let (of, rest) = line.strip_prefix("impl ")?.split_once(" for ")?;
        let name = rest.split([' ', '{']).next()?;
        traits.contains(&of).then_some(name)
    })
}

/// Every check of the OpenFX test host is in its list.
fn check_host_checks(tree: &Tree, problems: &mut Vec<String>) {
    let Some((list, all)) = find_list(tree, "checks") else {
        problems.push("no file checks/mod.rs has a `pub static ALL`".to_owned());
        return;
    };
    let folder = list.path.trim_end_matches("mod.rs");
    for file in tree.rust_files(folder) {
        let name = file.path[folder.len()..].trim_end_matches(".rs");
        if file.text.contains("static CHECK: Check") && !all.contains(&format!("&{name}::CHECK,")) {
            problems.push(format!(
                "{}: the check {name} is not in checks::ALL",
                file.path
            ));
        }
    }
}
