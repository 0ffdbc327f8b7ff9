//! The rules of the house, each with the message a breach of it gets.

mod doors;
mod edges;
mod files;
mod purity;
mod registries;

use std::fs;
use std::path::{Path, PathBuf};

/// The repository's root, as cargo says it at run time: a binary may outlive the checkout it was built in.
pub(crate) fn root() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    package
        .parent()
        .expect("xtask lies in the repository's root")
        .to_path_buf()
}

/// Every breach of a rule.
pub(crate) fn problems(root: &Path) -> Vec<String> {
    let tree = Tree::read(root);
    let mut problems = Vec::new();
    edges::check(&tree, &mut problems);
    files::check(&tree, &mut problems);
    purity::check(&tree, &mut problems);
    registries::check(&tree, &mut problems);
    doors::check(&tree, &mut problems);
    doors::header(root, &tree, &mut problems);
    problems
}

/// The project's text files by path from the root, `/` between folders.
pub(crate) struct Tree {
    files: Vec<(String, String)>,
}

impl Tree {
    fn read(root: &Path) -> Self {
        let mut files = Vec::new();
        let mut folders = vec![root.to_path_buf()];
        while let Some(folder) = folders.pop() {
            let Ok(entries) = fs::read_dir(&folder) else {
                continue;
            };
            for entry in entries.flatten() {
                let path = entry.path();
                let name = entry.file_name().to_string_lossy().into_owned();
                // In a work tree of its own `.git` is a file.
                if ["target", ".git", "seidel-demo"].contains(&name.as_str()) {
                    continue;
                }
                if path.is_dir() {
                    folders.push(path);
                } else if let Ok(text) = fs::read_to_string(&path)
                    && let Ok(relative) = path.strip_prefix(root)
                {
                    files.push((relative.to_string_lossy().replace('\\', "/"), text));
                }
            }
        }
        files.sort();
        Self { files }
    }

    /// Path and text of every file that `wanted` accepts by path.
    fn each<'a>(
        &'a self,
        wanted: impl Fn(&str) -> bool + 'a,
    ) -> impl Iterator<Item = (&'a str, &'a str)> {
        self.files
            .iter()
            .filter(move |(path, _)| wanted(path))
            .map(|(path, text)| (path.as_str(), text.as_str()))
    }

    /// Text of one file, empty if it is not there.
    fn text(&self, path: &str) -> &str {
        self.files
            .iter()
            .find(|(p, _)| p == path)
            .map_or("", |(_, text)| text)
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_house_is_in_order() {
        let problems = super::problems(&super::root());
        assert!(problems.is_empty(), "{}", problems.join("\n"));
    }

    #[test]
    fn breaches_are_found() {
        let tree = super::Tree {
            files: [
                (
                    "core/Cargo.toml",
                    "[dependencies]\nseidel.workspace = true\n",
                ),
                ("core/src/bad.rs", "fn f() { std::fs::read(\"x\"); }"),
                ("cli/src/commands/mod.rs", "mod fit;"),
                ("cli/src/commands/lost.rs", "//! Lost."),
                ("core/src/psf/lost.rs", "impl MomentPsf for Lost {"),
                (
                    "plugin/src/open.rs",
                    "#[unsafe(no_mangle)]\npub extern \"C\" fn ajar() {\n    guard(|| 1)\n}\n\
                     #[unsafe(no_mangle)]\npub extern \"C\" fn gaping() {\n    work();\n    guard(|| 1)\n}\n",
                ),
            ]
            .map(|(path, text)| (path.to_owned(), text.to_owned()))
            .to_vec(),
        };
        let mut problems = Vec::new();
        super::edges::check(&tree, &mut problems);
        super::purity::check(&tree, &mut problems);
        super::registries::check(&tree, &mut problems);
        super::doors::check(&tree, &mut problems);
        assert!(!problems.iter().any(|p| p.contains("ajar")), "{problems:?}");
        for part in ["seidel", "std::fs", "commands/lost.rs", "Lost", "gaping"] {
            assert!(
                problems.iter().any(|p| p.contains(part)),
                "{part} in {problems:?}"
            );
        }
    }
}
