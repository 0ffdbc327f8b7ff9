//! The workspace: its root, its packages and its text files.

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the repository.
///
/// Cargo's run-time value comes first, because a binary may outlive the checkout it was built in.
pub(crate) fn root() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    package
        .parent()
        .expect("xtask is a folder of the repository")
        .to_path_buf()
}

/// The project's text files, sorted by path.
pub(crate) struct Tree {
    files: Vec<TextFile>,
}

/// A text file of the project.
pub(crate) struct TextFile {
    /// Path from the root, with `/` between folders.
    pub(crate) path: String,
    pub(crate) text: String,
}

/// A package of the repository.
pub(crate) struct Package {
    pub(crate) name: String,
    /// Folder from the root, with `/` between folders.
    pub(crate) folder: String,
    /// Text of its `Cargo.toml`.
    pub(crate) manifest: String,
}

impl Tree {
    /// Reads every UTF-8 file below `root`, build output and the demo's output excepted.
    pub(crate) fn read(root: &Path) -> Self {
        let mut files = Vec::new();
        let mut folders = vec![root.to_path_buf()];
        while let Some(folder) = folders.pop() {
            let Ok(entries) = fs::read_dir(&folder) else {
                continue;
            };
            for entry in entries.flatten() {
                let path = entry.path();
                let name = entry.file_name().to_string_lossy().into_owned();
                // `.git` is a file in a linked worktree.
                if ["target", ".git", "seidel-demo"].contains(&name.as_str()) {
                    continue;
                }
                if path.is_dir() {
                    folders.push(path);
                } else if let Ok(text) = fs::read_to_string(&path)
                    && let Ok(relative) = path.strip_prefix(root)
                {
                    let path = relative.to_string_lossy().replace('\\', "/");
                    files.push(TextFile { path, text });
                }
            }
        }
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Self { files }
    }

    /// A tree of the given paths and texts.
    #[cfg(test)]
    pub(crate) fn of(files: &[(&str, &str)]) -> Self {
        let file = |&(path, text): &(&str, &str)| TextFile {
            path: path.to_owned(),
            text: text.to_owned(),
        };
        Self {
            files: files.iter().map(file).collect(),
        }
    }

    /// Every file.
    pub(crate) fn files(&self) -> impl Iterator<Item = &TextFile> {
        self.files.iter()
    }

    /// The Rust files whose path begins with `start`.
    pub(crate) fn rust_files(&self, start: &str) -> impl Iterator<Item = &TextFile> {
        self.files
            .iter()
            .filter(move |file| file.path.starts_with(start) && file.path.ends_with(".rs"))
    }

    /// The text of one file, empty if there is no such file.
    pub(crate) fn text(&self, path: &str) -> &str {
        self.files
            .iter()
            .find(|file| file.path == path)
            .map_or("", |file| &file.text)
    }

    /// The members that the root's `Cargo.toml` lists, and the packages that it excludes because they are workspaces of their
    /// own.
    ///
    /// # Errors
    /// A manifest that is missing, is not TOML or has no package name.
    pub(crate) fn packages(&self) -> Result<Vec<Package>, String> {
        let workspace = parse_manifest("Cargo.toml", self.text("Cargo.toml"))?;
        let members = workspace
            .get("workspace")
            .and_then(|table| table.get("members")?.as_array());
        let members = members.ok_or("Cargo.toml: has no workspace members")?;
        let excluded = workspace
            .get("workspace")
            .and_then(|table| table.get("exclude")?.as_array());
        let folders = members.iter().chain(excluded.into_iter().flatten());
        let folders = folders.filter_map(|member| member.as_str());
        folders.map(|folder| self.package(folder)).collect()
    }

    fn package(&self, folder: &str) -> Result<Package, String> {
        let path = format!("{folder}/Cargo.toml");
        let manifest = self.text(&path).to_owned();
        let table = parse_manifest(&path, &manifest)?;
        let name = table
            .get("package")
            .and_then(|package| package.get("name")?.as_str());
        let name = name.ok_or_else(|| format!("{path}: has no package name"))?;
        Ok(Package {
            name: name.to_owned(),
            folder: folder.to_owned(),
            manifest,
        })
    }
}

impl Package {
    /// Whether the package is the core or one of the packages in its folder.
    pub(crate) fn is_core(&self) -> bool {
        self.folder == "core" || self.folder.starts_with("core/")
    }

    /// The path of a file of the package, from the root.
    pub(crate) fn path(&self, file: &str) -> String {
        format!("{}/{file}", self.folder)
    }

    /// Names of everything the package depends on: for the product, for its tests and for its build script.
    pub(crate) fn dependencies(&self) -> Vec<String> {
        let table = self.manifest.parse().unwrap_or_default();
        let mut names = Vec::new();
        collect_dependencies(&table, &mut names);
        names
    }
}

fn parse_manifest(path: &str, text: &str) -> Result<toml::Table, String> {
    text.parse().map_err(|error| format!("{path}: {error}"))
}

/// Collects the names in all tables of dependencies, nested ones such as `[target.'cfg(unix)'.dependencies]` too.
fn collect_dependencies(table: &toml::Table, names: &mut Vec<String>) {
    for (key, value) in table {
        let Some(inner) = value.as_table() else {
            continue;
        };
        if key.ends_with("dependencies") {
            names.extend(inner.keys().cloned());
        } else {
            collect_dependencies(inner, names);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packages_come_from_the_manifests() {
        let tree = Tree::of(&[
            (
                "Cargo.toml",
                "[workspace]\nmembers = [\"core\", \"core/optics\"]\nexclude = [\"own\"]",
            ),
            ("own/Cargo.toml", "[workspace]\n[package]\nname = \"own\""),
            ("core/Cargo.toml", "[package]\nname = \"facade\""),
            (
                "core/optics/Cargo.toml",
                "[package]\nname = \"optics\"\n[dependencies]\na = \"1\"\n\
                 [target.'cfg(unix)'.dev-dependencies.b]\nversion = \"1\"",
            ),
        ]);
        let packages = tree.packages().expect("valid manifests");
        let names: Vec<&str> = packages.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["facade", "optics", "own"]);
        assert!(packages[..2].iter().all(Package::is_core));
        assert_eq!(packages[1].dependencies(), ["a", "b"]);
        assert!(Tree::of(&[]).packages().is_err());
    }
}
