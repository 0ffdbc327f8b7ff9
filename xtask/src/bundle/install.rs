//! Copying the bundle to where hosts look for plugins.

use std::fs;
use std::path::{Path, PathBuf};

use super::NAME;
use super::layout::{failed, remove, replace};

/// Where a bundle goes, and what the user has to know of it.
#[derive(Debug, PartialEq)]
struct Place {
    folder: PathBuf,
    note: String,
}

/// The place that hosts look at by themselves on each platform.
fn standard() -> PathBuf {
    match std::env::consts::OS {
        "macos" => "/Library/OFX/Plugins".into(),
        "windows" => r"C:\Program Files\Common Files\OFX\Plugins".into(),
        _ => "/usr/OFX/Plugins".into(),
    }
}

/// Where to install: as said; else the first folder of OFX_PLUGIN_PATH; else the standard one if it can be written to;
/// else one of the user's, which hosts must be told of.
fn place(
    said: Option<PathBuf>,
    path: Option<&str>,
    home: Option<PathBuf>,
    standard_is_open: bool,
) -> Result<Place, String> {
    let quiet = |folder| Place {
        folder,
        note: String::new(),
    };
    if let Some(folder) = said {
        return Ok(quiet(folder));
    }
    // Windows and macOS part folders by semicolons, Linux by colons.
    let mark = if std::env::consts::OS == "linux" {
        ':'
    } else {
        ';'
    };
    let first = path.and_then(|path| path.split(mark).find(|folder| !folder.is_empty()));
    if let Some(first) = first {
        return Ok(quiet(first.into()));
    }
    if standard_is_open {
        return Ok(quiet(standard()));
    }
    let home = home.ok_or("there is no home folder; give --to FOLDER")?;
    let folder = home.join("OFX").join("Plugins");
    let note = format!(
        "\nHosts do not look there by themselves: set OFX_PLUGIN_PATH to {}, or copy the bundle to {} as administrator.",
        folder.display(),
        standard().display()
    );
    Ok(Place { folder, note })
}

/// Whether a file can be made in the standard folder.
fn is_open(folder: &Path) -> bool {
    let probe = folder.join(format!(".{NAME}.probe"));
    let open = fs::create_dir(&probe).is_ok();
    if open {
        let _ = fs::remove_dir(&probe);
    }
    open
}

/// Copies `bundle`, whole or not at all; where to, in words.
pub(super) fn install(bundle: &Path, to: Option<PathBuf>) -> Result<String, String> {
    let path = std::env::var("OFX_PLUGIN_PATH").ok();
    let home = std::env::home_dir();
    let place = place(to, path.as_deref(), home, is_open(&standard()))?;
    let folder = &place.folder;
    fs::create_dir_all(folder).map_err(|e| failed(folder, &e))?;
    // Hosts skip what begins with @.
    let part = folder.join(format!("@{NAME}.part"));
    remove(&part)?;
    copy(bundle, &part)?;
    let installed = folder.join(format!("{NAME}.ofx.bundle"));
    replace(&part, &installed)?;
    Ok(format!("installed: {}{}", installed.display(), place.note))
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    fs::create_dir_all(to).map_err(|e| failed(to, &e))?;
    let entries = fs::read_dir(from).map_err(|e| failed(from, &e))?;
    for entry in entries {
        let entry = entry.map_err(|e| failed(from, &e))?;
        let (old, new) = (entry.path(), to.join(entry.file_name()));
        if old.is_dir() {
            copy(&old, &new)?;
        } else {
            fs::copy(&old, &new).map_err(|e| failed(&old, &e))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_place_is_what_is_said_then_what_hosts_look_at() {
        let home = || Some(PathBuf::from("h"));
        let folder = |said: Option<&str>, path, open| {
            let place = place(said.map(PathBuf::from), path, home(), open);
            place.expect("a place").folder
        };
        let two = if std::env::consts::OS == "linux" {
            ":a:b"
        } else {
            ";a;b"
        };
        assert_eq!(folder(Some("s"), Some(two), true), PathBuf::from("s"));
        assert_eq!(folder(None, Some(two), true), PathBuf::from("a"));
        assert_eq!(folder(None, Some(""), true), standard());
        let own = place(None, None, home(), false).expect("a place");
        assert_eq!(own.folder, Path::new("h").join("OFX").join("Plugins"));
        assert!(own.note.contains("OFX_PLUGIN_PATH"));
        assert!(place(None, None, None, false).is_err());
    }

    #[test]
    fn installing_replaces_what_was_there_as_a_whole() {
        let folder = std::env::temp_dir().join(format!("seidel-install-{}", std::process::id()));
        let bundle = folder.join("made/Seidel.ofx.bundle");
        fs::create_dir_all(bundle.join("Contents/Resources")).expect("a folder");
        fs::write(bundle.join("Contents/Info.plist"), "new").expect("written");
        let to = folder.join("plugins");
        let old = to.join("Seidel.ofx.bundle/Contents");
        fs::create_dir_all(&old).expect("a folder");
        fs::write(old.join("stale"), "old").expect("written");
        let said = install(&bundle, Some(to.clone())).expect("installed");
        assert!(said.contains("Seidel.ofx.bundle"));
        let text = fs::read_to_string(old.join("Info.plist"));
        assert_eq!(text.expect("copied"), "new");
        assert!(!old.join("stale").exists());
        assert_eq!(fs::read_dir(&to).expect("read").count(), 1);
        fs::remove_dir_all(&folder).expect("removed");
    }
}
