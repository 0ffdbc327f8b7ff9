//! Names in file knobs that are no files: `library:NAME`, `ocio://NAME`, `seidel`.
//!
//! Natron takes them for relative paths: it puts the folder of the project in front of them when a project is saved.

use std::borrow::Cow;
use std::path::Path;

use seidel_optics::library;

/// Separators of folders in paths, on all platforms on which a project may have been saved.
const SEPARATORS: [char; 2] = ['/', '\\'];

/// The scheme of configs that are built into OpenColorIO.
const OCIO: &str = "ocio:";

/// Returns the lens that `text` names: a lens of the library, with or without a folder in front of it, or else a file.
pub(crate) fn lens(text: &str) -> &str {
    let name = text.rsplit(SEPARATORS).next().unwrap_or(text);
    if name.starts_with(library::PREFIX) && !Path::new(text).exists() {
        name
    } else {
        text
    }
}

/// Returns the config that `text` names: Seidel's own or one built into OpenColorIO, with or without a folder in front of it, or else
/// a file.
pub(crate) fn config(text: &str) -> Cow<'_, str> {
    if Path::new(text).exists() {
        return text.into();
    }
    let behind_folder = |start: usize| text[..start].ends_with(SEPARATORS);
    if let Some(start) = text.rfind(OCIO)
        && behind_folder(start)
    {
        // Cleaning of paths makes one slash of two.
        let name = text[start + OCIO.len()..].trim_start_matches(SEPARATORS);
        return format!("{OCIO}//{name}").into();
    }
    match text.rsplit(SEPARATORS).next() {
        Some("seidel") => "seidel".into(),
        _ => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_found_behind_folders() {
        for text in [
            "library:my fast",
            "/shots/a b/library:my fast",
            "C:\\shots\\library:my fast",
        ] {
            assert_eq!(lens(text), "library:my fast");
        }
        for text in ["/shots/lens.json", "/library:old/lens.json", ""] {
            assert_eq!(lens(text), text);
        }
        assert_eq!(config("/shots/seidel"), "seidel");
        for text in [
            "ocio://default",
            "/shots/ocio://default",
            "/shots/ocio:/default",
            "C:\\shots\\ocio:\\default",
        ] {
            assert_eq!(config(text), "ocio://default");
        }
        for text in ["/shots/seidel.ocio", "/seidel/config.ocio", ""] {
            assert_eq!(config(text), text);
        }
    }

    #[test]
    fn files_of_such_names_are_files() {
        let folder = std::env::temp_dir().join(format!("seidel-ofx-names-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        for name in ["library:a", "seidel"] {
            let path = folder.join(name).display().to_string();
            std::fs::write(&path, "").expect("written");
            assert_eq!((lens(&path), &*config(&path)), (&*path, &*path));
        }
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
