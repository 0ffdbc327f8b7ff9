//! Folders of generated files.

use std::fs;
use std::path::Path;

/// A folder that a task generates.
pub(crate) struct GeneratedFolder {
    /// Name of the task.
    pub(crate) task: &'static str,
    /// Path from the root.
    pub(crate) path: &'static str,
}

/// The path within the folder, and the text, of every generated file.
pub(crate) type Files = Vec<(String, String)>;

impl GeneratedFolder {
    /// Writes the files that are missing or out of date; returns a report. With `--check` it writes nothing.
    ///
    /// `foreign` lists files of the folder that do not belong there.
    ///
    /// # Errors
    /// Those of `generate` and `foreign`, files that cannot be written, and with `--check` files that are out of date.
    pub(crate) fn update(
        &self,
        root: &Path,
        mut arguments: impl Iterator<Item = String>,
        generate: impl FnOnce() -> Result<Files, String>,
        foreign: impl FnOnce(&Path, &Files) -> Result<Vec<String>, String>,
    ) -> Result<String, String> {
        let Self { task, path } = self;
        let check = match arguments.next().as_deref() {
            None => false,
            Some("--check") => true,
            Some(other) => {
                return Err(format!("unknown argument {other}; the only one is --check"));
            }
        };
        let files = generate()?;
        let folder = root.join(path);
        let mut stale = Vec::new();
        for (name, text) in &files {
            let file = folder.join(name);
            if fs::read(&file).is_ok_and(|old| old == text.as_bytes()) {
                continue;
            }
            stale.push(format!("{path}/{name}"));
            if !check {
                let parent = file.parent().unwrap_or(&folder);
                let written = fs::create_dir_all(parent).and_then(|()| fs::write(&file, text));
                written.map_err(|e| format!("{path}/{name}: {e}"))?;
            }
        }
        stale.extend(foreign(&folder, &files)?);
        let list = stale.join(", ");
        if stale.is_empty() {
            Ok(format!("{task}: {} files are up to date", files.len()))
        } else if check {
            Err(format!("out of date: {list}; run `cargo xtask {task}`"))
        } else {
            Ok(format!("{task}: wrote {list}"))
        }
    }
}
