//! The files by which builds find libseidel: for pkg-config and CMake.

use std::fs;
use std::path::Path;

use super::archive::Entry;

/// The templates, each with its place in the archive.
pub(super) const TEMPLATES: [[&str; 2]; 3] = [
    ["plugin/package/seidel.pc", "lib/pkgconfig/seidel.pc"],
    [
        "plugin/package/SeidelConfig.cmake",
        "lib/cmake/Seidel/SeidelConfig.cmake",
    ],
    [
        "plugin/package/SeidelConfigVersion.cmake",
        "lib/cmake/Seidel/SeidelConfigVersion.cmake",
    ],
];

/// The names that templates leave open.
pub(super) struct Names<'a> {
    pub(super) version: &'a str,
    /// File name of the shared library.
    pub(super) library: &'a str,
    /// File name of the library that programs are linked with: on Windows another one.
    pub(super) import: &'a str,
}

/// Returns the files, filled in.
pub(super) fn entries(root: &Path, names: &Names) -> Result<Vec<Entry>, String> {
    let entry = |[from, to]: [&str; 2]| {
        let text = fs::read_to_string(root.join(from)).map_err(|e| format!("{from}: {e}"))?;
        let text = text
            .replace("@VERSION@", names.version)
            .replace("@LIBRARY@", names.library)
            .replace("@IMPORT_LIBRARY@", names.import);
        Ok(Entry::text(to, text))
    };
    TEMPLATES.into_iter().map(entry).collect()
}
