//! Every Rust file is part of a build: a module of another file, or a target of its package.

use crate::workspace::{Package, Tree};

/// File names that a folder's modules may be declared in.
const ROOTS: [&str; 3] = ["mod.rs", "lib.rs", "main.rs"];

pub(super) fn check(tree: &Tree, packages: &[Package], problems: &mut Vec<String>) {
    for file in tree.rust_files("") {
        let owner = packages
            .iter()
            .filter(|package| file.path.starts_with(&package.path("")))
            .max_by_key(|package| package.folder.len());
        let Some(package) = owner else {
            problems.push(format!("{}: belongs to no package", file.path));
            continue;
        };
        let inner = &file.path[package.folder.len() + 1..];
        if package.manifest.contains(&format!("\"{inner}\"")) {
            continue;
        }
        let Some((name, parents)) = module(&file.path) else {
            continue;
        };
        let parents: Vec<&str> = (parents.iter().map(|path| tree.text(path)))
            .filter(|text| !text.is_empty())
            .collect();
        let declaration = format!("mod {name};");
        if !parents.is_empty() && !parents.iter().any(|text| text.contains(&declaration)) {
            problems.push(format!("{}: no file declares `{declaration}`", file.path));
        }
    }
}

/// The module name of a file, and the files that may declare it. `None` for the root of a crate.
fn module(path: &str) -> Option<(&str, Vec<String>)> {
    let (folder, file) = path.rsplit_once('/')?;
    let (folder, name) = match file {
        "lib.rs" | "main.rs" | "build.rs" => return None,
        "mod.rs" => folder.rsplit_once('/')?,
        file => (folder, file.strip_suffix(".rs")?),
    };
    let mut parents: Vec<String> = ROOTS
        .iter()
        .map(|root| format!("{folder}/{root}"))
        .collect();
    parents.push(format!("{folder}.rs"));
    Some((name, parents))
}

#[cfg(test)]
mod tests {
    use super::module;

    #[test]
    fn modules_are_declared_one_level_up() {
        let (name, parents) = module("a/src/b/mod.rs").expect("a module");
        assert_eq!(name, "b");
        assert!(parents.contains(&"a/src/lib.rs".to_owned()));
        let (name, parents) = module("a/src/b/c.rs").expect("a module");
        assert_eq!(name, "c");
        assert!(parents.contains(&"a/src/b/mod.rs".to_owned()));
        assert!(parents.contains(&"a/src/b.rs".to_owned()));
        assert!(module("a/src/main.rs").is_none());
    }
}
