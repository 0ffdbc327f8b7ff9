//! `cargo xtask luts`: the OpenColorIO config and the tables of `luts/`, generated from `luts/curves.toml`.

mod camera;
mod config;
mod cube;

use std::fs;
use std::path::Path;

use seidel_colour::curves::CurveTable;

use crate::generated::{Files, GeneratedFolder};

/// The folder, from the root.
const LUTS: &str = "luts";

/// Runs `cargo xtask luts`.
///
/// # Errors
/// An invalid `curves.toml`, and those of [`GeneratedFolder::update`].
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let folder = GeneratedFolder {
        task: "luts",
        path: LUTS,
    };
    folder.update(root, arguments, || generate(root), |_, _| Ok(Vec::new()))
}

/// Returns the path within the folder, and the text, of every generated file.
fn generate(root: &Path) -> Result<Files, String> {
    let source = root.join(LUTS).join("curves.toml");
    let text = fs::read_to_string(&source).map_err(|e| format!("{}: {e}", source.display()))?;
    let table = CurveTable::parse(&text).map_err(|e| e.to_string())?;
    let mut files = vec![("config.ocio".to_owned(), config::text(&table)?)];
    files.extend(camera::files(&table)?);
    files.extend(cube::files(&table)?);
    Ok(files)
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_files_are_up_to_date() {
        let arguments = ["--check".to_owned()].into_iter();
        super::run(&crate::workspace::root(), arguments).expect("up to date");
    }
}
