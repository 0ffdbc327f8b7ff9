//! Lens profiles in the folder that `SEIDEL_LENSES` names.

use std::ffi::CString;
use std::path::PathBuf;

use seidel_optics::library::FOLDER_VARIABLE;

/// Largest number of profiles in the menu.
const MOST: usize = 500;

/// Returns the folder, if one is named.
fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os(FOLDER_VARIABLE)?;
    (!folder.is_empty()).then(|| PathBuf::from(folder))
}

/// Returns the path of the file called `name` in the folder, if there is one.
pub(super) fn file(name: &str) -> Option<PathBuf> {
    Some(folder()?.join(name)).filter(|path| path.is_file())
}

/// Returns the names of the profiles in the folder, without `.json`, in their order: the menu of a host that asks now.
pub(crate) fn names() -> Vec<CString> {
    let entries = folder().and_then(|folder| std::fs::read_dir(folder).ok());
    let mut names: Vec<String> = (entries.into_iter().flatten().flatten())
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            Some(name.strip_suffix(".json")?.to_owned())
        })
        .collect();
    names.sort();
    names.truncate(MOST);
    // Names from the file system hold no zero.
    let names = names.into_iter().filter_map(|name| CString::new(name).ok());
    names.collect()
}
