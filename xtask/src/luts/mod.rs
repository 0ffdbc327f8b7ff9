//! `cargo xtask luts`: the OpenColorIO config and the tables of `luts/`, generated from `luts/curves.toml`.

mod camera;
mod config;
mod cube;

use std::fs;
use std::path::Path;

use seidel_colour::curves::CurveTable;

/// The folder, from the root.
const LUTS: &str = "luts";

/// Writes the files that are missing or out of date; returns a report. With `--check` it writes nothing.
///
/// # Errors
/// An invalid `curves.toml`, files that cannot be written, and with `--check` files that are out of date.
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
    let files = generate(root)?;
    let folder = root.join(LUTS);
    let mut stale = Vec::new();
    for (name, text) in &files {
        let path = folder.join(name);
        if fs::read(&path).is_ok_and(|old| old == text.as_bytes()) {
            continue;
        }
        stale.push(format!("{LUTS}/{name}"));
        if !check {
            let parent = path.parent().unwrap_or(&folder);
            let written = fs::create_dir_all(parent).and_then(|()| fs::write(&path, text));
            written.map_err(|e| format!("{LUTS}/{name}: {e}"))?;
        }
    }
    let list = stale.join(", ");
    if stale.is_empty() {
        Ok(format!("luts: {} files are up to date", files.len()))
    } else if check {
        Err(format!("out of date: {list}; run `cargo xtask luts`"))
    } else {
        Ok(format!("luts: wrote {list}"))
    }
}

/// Returns the path within the folder, and the text, of every generated file.
fn generate(root: &Path) -> Result<Vec<(String, String)>, String> {
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
