//! `cargo xtask library`: the lens profiles and sheets of `core/optics/library`, generated from designs.

mod designs;
mod profile;
mod sheet;

use std::fs;
use std::path::Path;

/// The folder, from the root.
const FOLDER: &str = "core/optics/library";

/// Writes the files that are missing or out of date; returns a report. With `--check` it writes nothing.
///
/// # Errors
/// Designs that are no valid lens, files that cannot be written, and with `--check` files that are out of date.
pub(crate) fn run(
    root: &Path,
    mut arguments: impl Iterator<Item = String>,
) -> Result<String, String> {
    let check = match arguments.next().as_deref() {
        None => false,
        Some("--check") => true,
        Some(other) => {
            return Err(format!("unknown argument {other}; the only one is --check"));
        }
    };
    let files = generate()?;
    let folder = root.join(FOLDER);
    let mut stale = Vec::new();
    for (name, text) in &files {
        let path = folder.join(name);
        if fs::read(&path).is_ok_and(|old| old == text.as_bytes()) {
            continue;
        }
        stale.push(format!("{FOLDER}/{name}"));
        if !check {
            let written = fs::create_dir_all(&folder).and_then(|()| fs::write(&path, text));
            written.map_err(|e| format!("{FOLDER}/{name}: {e}"))?;
        }
    }
    stale.extend(foreign(&folder, &files)?);
    let list = stale.join(", ");
    if stale.is_empty() {
        Ok(format!("library: {} files are up to date", files.len()))
    } else if check {
        Err(format!("out of date: {list}; run `cargo xtask library`"))
    } else {
        Ok(format!("library: wrote {list}"))
    }
}

/// Returns the files of the folder that no design makes.
///
/// # Errors
/// A folder that cannot be listed.
fn foreign(folder: &Path, files: &[(String, String)]) -> Result<Vec<String>, String> {
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
fn generate() -> Result<Vec<(String, String)>, String> {
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
