//! Third-party notices: the licence texts of every library in the binaries of some packages.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::Cargo;

/// The library that no list of dependencies names.
const STANDARD_LIBRARY: &str = "

There is also the Rust standard library (MIT OR Apache-2.0, copyright The Rust Project Contributors,
https://github.com/rust-lang/rust/blob/master/COPYRIGHT).
";

/// The runtime that is linked into binaries for `windows-gnu`.
const MINGW: &str = include_str!("mingw-notice.txt");

/// Parts of the names of files that hold a licence or a notice.
const LICENCE_FILES: [&str; 5] = ["LICENSE", "LICENCE", "COPYING", "COPYRIGHT", "NOTICE"];

/// The MIT licence after its copyright line, for packages that state it and include no file.
const MIT: &str = "Permission is hereby granted, free of charge, to any person obtaining a copy of this software and
associated documentation files (the \"Software\"), to deal in the Software without restriction,
including without limitation the rights to use, copy, modify, merge, publish, distribute,
sublicense, and/or sell copies of the Software, and to permit persons to whom the Software is
furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or
substantial portions of the Software.

THE SOFTWARE IS PROVIDED \"AS IS\", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT
NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND
NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM,
DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT
OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.";

/// A library in the binary.
#[derive(Debug)]
struct Library {
    /// Name and version.
    title: String,
    /// SPDX expression.
    licence: String,
    authors: String,
    repository: String,
    /// Folder of its sources.
    folder: PathBuf,
}

/// Returns the notices for the binaries of `packages` on a target; `head` is their first line.
///
/// # Errors
/// Output of cargo that cannot be read, and a library without a licence.
pub(crate) fn generate(
    cargo: &Cargo<'_>,
    packages: &[&str],
    triple: &str,
    head: &str,
) -> Result<String, String> {
    // The tree knows which optional dependencies are in use, the metadata knows where they are.
    let mut arguments = vec!["tree", "--locked", "--edges", "normal,no-proc-macro"];
    arguments.extend(["--prefix", "none", "--format", "{p}", "--target", triple]);
    arguments.extend(packages.iter().flat_map(|package| ["--package", package]));
    let tree = cargo.output(&arguments)?;
    let metadata = cargo.output(&[
        "metadata",
        "--locked",
        "--format-version",
        "1",
        "--filter-platform",
        triple,
    ])?;
    let metadata = serde_json::from_str(&metadata).map_err(|e| format!("cargo metadata: {e}"))?;
    let mut text = text(head, &libraries(&tree, &metadata)?)?;
    if triple.ends_with("windows-gnu") {
        text.push_str(MINGW);
    }
    Ok(text)
}

/// The libraries of `cargo tree` that are not packages of this project.
fn libraries(tree: &str, metadata: &Value) -> Result<Vec<Library>, String> {
    let titles: BTreeSet<String> = tree.lines().filter_map(title_of_line).collect();
    let packages = metadata["packages"].as_array();
    let packages = packages.ok_or("cargo metadata: has no packages")?;
    let mut libraries: Vec<Library> = packages
        .iter()
        .filter(|package| !package["source"].is_null())
        .map(library)
        .filter(|library| titles.contains(&library.title))
        .collect();
    libraries.sort_by(|a, b| a.title.cmp(&b.title));
    Ok(libraries)
}

/// "name version" of a line such as `name v1.2.3 (*)`.
fn title_of_line(line: &str) -> Option<String> {
    let (name, rest) = line.split_once(" v")?;
    let version = rest.split_whitespace().next()?;
    Some(format!("{name} {version}"))
}

fn library(package: &Value) -> Library {
    let string = |key: &str| package[key].as_str().unwrap_or("").to_owned();
    let authors = package["authors"].as_array().into_iter().flatten();
    let authors: Vec<&str> = authors.filter_map(Value::as_str).collect();
    let manifest = PathBuf::from(string("manifest_path"));
    Library {
        title: format!("{} {}", string("name"), string("version")),
        licence: string("license"),
        authors: authors.join(", "),
        repository: string("repository"),
        folder: manifest.parent().unwrap_or(Path::new("")).to_path_buf(),
    }
}

fn text(head: &str, libraries: &[Library]) -> Result<String, String> {
    let mut text = format!("{head}{STANDARD_LIBRARY}");
    // Libraries by the licence text they share.
    let mut users = BTreeMap::<String, Vec<&str>>::new();
    for library in libraries {
        let Library {
            title,
            licence,
            repository,
            ..
        } = library;
        text.push_str(format!("\n{title}: {licence} {repository}").trim_end());
        for licence_text in licence_texts(library)? {
            users.entry(licence_text).or_default().push(title);
        }
    }
    let mut sections: Vec<(String, Vec<&str>)> = users.into_iter().collect();
    sections.sort_by(|(_, a), (_, b)| a.cmp(b));
    for (licence_text, titles) in sections {
        let line = "-".repeat(80);
        let titles = titles.join(", ");
        text.push_str(&format!("\n\n{line}\n{titles}\n\n{licence_text}"));
    }
    text.push('\n');
    Ok(text)
}

/// The texts of a library's licence files, or the standard text if it has none.
fn licence_texts(library: &Library) -> Result<Vec<String>, String> {
    let entries = fs::read_dir(&library.folder);
    let entries = entries.map_err(|e| format!("{}: {e}", library.folder.display()))?;
    let mut paths: Vec<PathBuf> = entries
        .flatten()
        .filter(|entry| {
            let name = entry.file_name().to_string_lossy().to_uppercase();
            LICENCE_FILES.iter().any(|part| name.contains(part)) && entry.path().is_file()
        })
        .map(|entry| entry.path())
        .collect();
    paths.sort();
    let mut texts = Vec::new();
    for path in paths {
        let bytes = fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n");
        texts.push(text.trim().to_owned());
    }
    if !texts.is_empty() {
        return Ok(texts);
    }
    let is_mit = library
        .licence
        .split([' ', '/', '(', ')'])
        .any(|id| id == "MIT");
    if is_mit {
        let title = &library.title;
        let holders = match library.authors.as_str() {
            "" => format!("the authors of {title}"),
            authors => authors.to_owned(),
        };
        return Ok(vec![format!(
            "MIT License\n\nCopyright (c) {holders}\n\n{MIT}"
        )]);
    }
    Err(format!(
        "{}: its licence is \"{}\" and its sources contain no licence file; add its text to the notices by hand",
        library.title, library.licence
    ))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Metadata of packages `a`, `b` and `c` with sources in `folder`.
    fn metadata(folder: &Path) -> Value {
        let package = |name: &str, licence: &str| {
            let source = folder.join(name);
            fs::create_dir_all(&source).expect("a folder");
            json!({
                "name": name, "version": "1.0.0", "license": licence, "authors": ["An Author"],
                "source": "registry", "manifest_path": source.join("Cargo.toml"),
            })
        };
        let packages = [
            package("a", "MIT"),
            package("b", "Zlib"),
            package("c", "MIT"),
        ];
        json!({ "packages": packages })
    }

    const TREE: &str = "seidel-ofx v0.1.0 (path)\na v1.0.0\nb v1.0.0\nb v1.0.0 (*)\n";

    #[test]
    fn each_library_is_listed_and_equal_texts_appear_once() {
        let folder = tempfile::tempdir().expect("a folder");
        let metadata = metadata(folder.path());
        for name in ["a", "b"] {
            let path = folder.path().join(name).join("License.md");
            fs::write(path, "The shared text.\r\n").expect("written");
        }
        let libraries = libraries(TREE, &metadata).expect("libraries");
        let text = text("Head.", &libraries).expect("notices");
        assert!(text.contains("\na 1.0.0: MIT") && text.contains("\nb 1.0.0: Zlib"));
        assert!(
            text.contains("a 1.0.0, b 1.0.0\n\nThe shared text.\n"),
            "{text}"
        );
        assert_eq!(text.matches("The shared text.").count(), 1);
        assert!(!text.contains("c 1.0.0"), "not in the tree: {text}");
        assert!(!text.contains("seidel-ofx"), "ours: {text}");
    }

    #[test]
    fn the_mit_licence_needs_no_file_and_others_do() {
        let folder = tempfile::tempdir().expect("a folder");
        let metadata = metadata(folder.path());
        let problem = libraries(TREE, &metadata).and_then(|libraries| text("Head.", &libraries));
        assert!(problem.expect_err("b has no text").contains("b 1.0.0"));
        fs::write(folder.path().join("b/COPYING"), "Zlib text").expect("written");
        let libraries = libraries(TREE, &metadata).expect("libraries");
        let text = text("Head.", &libraries).expect("notices");
        assert!(
            text.contains("Copyright (c) An Author\n\nPermission"),
            "{text}"
        );
    }

    /// The notices of this workspace contain a text for everything the plugin links.
    #[test]
    fn every_library_of_the_plugin_has_a_licence() {
        let root = crate::workspace::root();
        let cargo = Cargo::new(&root);
        let triple = super::super::host_triple();
        let text = generate(&cargo, &[super::super::PACKAGE], &triple, "Head.").expect("notices");
        for name in ["\nnalgebra ", "\nrustfft ", "\nrayon "] {
            assert!(text.contains(name), "{name}");
        }
        assert!(
            !text.contains("\nserde_derive "),
            "a macro is not in the binary"
        );
        assert!(!text.contains("\nproptest "), "tests are not in the binary");
    }
}
