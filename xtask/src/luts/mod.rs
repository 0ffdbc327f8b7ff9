//! `cargo xtask luts`: the config and the tables of `luts/`, made of `luts/curves.toml`.

mod camera;
mod config;
mod cube;

use std::fs;
use std::path::Path;

use seidel_colour::curves::CurveTable;

/// The room, from the root.
const LUTS: &str = "luts";

/// Writes what is to be there, or with `--check` compares; what was done or is amiss.
///
/// # Errors
/// A table that is not in order, files that cannot be written, and with `--check` those that are out of date.
pub(crate) fn run(root: &Path, mut args: impl Iterator<Item = String>) -> Result<String, String> {
    let check = match args.next().as_deref() {
        None => false,
        Some("--check") => true,
        Some(other) => return Err(format!("does not know {other}; there is --check")),
    };
    let files = made(root)?;
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
    match (stale.is_empty(), check) {
        (true, _) => Ok(format!("luts: {} files are up to date", files.len())),
        (false, false) => Ok(format!("luts: wrote {}", stale.join(", "))),
        (false, true) => Err(format!(
            "{} are out of date; run `cargo xtask luts`",
            stale.join(", ")
        )),
    }
}

/// Every file that is made, by its path in the room.
fn made(root: &Path) -> Result<Vec<(String, String)>, String> {
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
    /// What is kept is what its source says, to the byte.
    #[test]
    fn the_room_is_up_to_date() {
        let args = ["--check".to_owned()].into_iter();
        super::run(&crate::workspace::root(), args).expect("up to date");
    }
}
