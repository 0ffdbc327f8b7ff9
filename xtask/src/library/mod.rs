//! `cargo xtask library`: the lens profiles and sheets of `core/optics/library`, generated from designs.

mod designs;
mod profile;
mod sheet;

use std::fs;
use std::path::Path;

use crate::generated::{Files, GeneratedFolder};

/// The folder, from the root.
const FOLDER: &str = "core/optics/library";

/// Runs `cargo xtask library`.
///
/// # Errors
/// Designs that are no valid lens, and those of [`GeneratedFolder::update`].
pub(crate) fn run(root: &Path, arguments: impl Iterator<Item = String>) -> Result<String, String> {
    let folder = GeneratedFolder {
        task: "library",
        path: FOLDER,
    };
    folder.update(root, arguments, generate, foreign)
}

/// Returns the files of the folder that no design makes.
///
/// # Errors
/// A folder that cannot be listed.
fn foreign(folder: &Path, files: &Files) -> Result<Vec<String>, String> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{FOLDER}: {e}"))?;
    let names = entries
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned());
    let unknown = names.filter(|name| !files.iter().any(|(own, _)| own == name));
    Ok(unknown
        .map(|name| format!("{FOLDER}/{name} (of no design: remove it)"))
        .collect())
}

/// Returns the name and the text of every generated file.
fn generate() -> Result<Files, String> {
    let mut files = Vec::new();
    for design in designs::ALL {
        let profile = profile::profile(design)?;
        files.push((format!("{}.json", design.name), profile.to_json()));
        let sheet = sheet::sheet(design);
        files.push((format!("{}.sheet.json", design.name), sheet.to_json()));
    }
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
