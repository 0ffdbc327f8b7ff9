//! Copying the bundle to a folder where hosts look for plugins.

use std::fs;
use std::path::{Path, PathBuf};

use super::NAME;
use super::layout::{failure, remove, replace};

/// A folder to install into.
#[derive(Debug, PartialEq)]
struct Destination {
    folder: PathBuf,
    /// Advice for the user, empty if none is needed.
    advice: String,
}

/// The folders that the destination is chosen from.
#[derive(Default)]
struct Candidates<'a> {
    /// `--to`.
    argument: Option<PathBuf>,
    /// The environment variable `OFX_PLUGIN_PATH`.
    plugin_path: Option<&'a str>,
    home: Option<PathBuf>,
    standard_is_writable: bool,
}

impl Candidates<'_> {
    /// The first there is of: the argument, the first folder of `OFX_PLUGIN_PATH`, the standard folder if it is
    /// writable, a folder in the user's home, which hosts need `OFX_PLUGIN_PATH` to find.
    fn choose(self) -> Result<Destination, String> {
        // OpenFX: folders are separated by colons on Linux, and by semicolons on Windows and macOS.
        let is_linux = std::env::consts::OS == "linux";
        let separator = if is_linux { ':' } else { ';' };
        let mut folders = self
            .plugin_path
            .into_iter()
            .flat_map(|path| path.split(separator));
        let first = folders.find(|folder| !folder.is_empty()).map(PathBuf::from);
        let standard = self.standard_is_writable.then(standard_folder);
        if let Some(folder) = self.argument.or_else(|| first.clone()).or(standard) {
            let advice = if folder == standard_folder() {
                "\nEvery OpenFX host finds it at its next start, for all users.".to_owned()
            } else if first.as_ref() == Some(&folder) {
                "\nHosts find it that are started with the OFX_PLUGIN_PATH of this shell, such as from this shell.".to_owned()
            } else {
                advice_about(&folder)
            };
            return Ok(Destination { folder, advice });
        }
        let home = self
            .home
            .ok_or("there is no home folder; give --to FOLDER")?;
        let folder = home.join("OFX").join("Plugins");
        let advice = advice_about(&folder);
        Ok(Destination { folder, advice })
    }
}

/// Returns what to do for hosts that do not search `folder`.
fn advice_about(folder: &Path) -> String {
    format!(
        "\nNo host finds it yet: set OFX_PLUGIN_PATH to {} where hosts are started, or copy the bundle to {} as administrator.",
        folder.display(),
        standard_folder().display()
    )
}

/// The folder that every host searches.
fn standard_folder() -> PathBuf {
    match std::env::consts::OS {
        "macos" => "/Library/OFX/Plugins".into(),
        "windows" => r"C:\Program Files\Common Files\OFX\Plugins".into(),
        _ => "/usr/OFX/Plugins".into(),
    }
}

fn is_writable(folder: &Path) -> bool {
    let probe = folder.join(format!(".{NAME}.probe"));
    let is_writable = fs::create_dir(&probe).is_ok();
    if is_writable {
        let _ = fs::remove_dir(&probe);
    }
    is_writable
}

/// Installs `bundle`, as a whole or not at all; returns a report.
///
/// # Errors
/// A folder that cannot be written, and no home folder where one is needed.
pub(super) fn install(bundle: &Path, to: Option<PathBuf>) -> Result<String, String> {
    let plugin_path = std::env::var("OFX_PLUGIN_PATH").ok();
    let candidates = Candidates {
        argument: to,
        plugin_path: plugin_path.as_deref(),
        home: std::env::home_dir(),
        standard_is_writable: is_writable(&standard_folder()),
    };
    let Destination { folder, advice } = candidates.choose()?;
    fs::create_dir_all(&folder).map_err(|e| failure(&folder, &e))?;
    // Hosts skip names that begin with @.
    let part = folder.join(format!("@{NAME}.part"));
    remove(&part)?;
    copy(bundle, &part)?;
    let installed = folder.join(format!("{NAME}.ofx.bundle"));
    replace(&part, &installed)?;
    Ok(format!("installed: {}{advice}", installed.display()))
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    fs::create_dir_all(to).map_err(|e| failure(to, &e))?;
    let entries = fs::read_dir(from).map_err(|e| failure(from, &e))?;
    for entry in entries {
        let entry = entry.map_err(|e| failure(from, &e))?;
        let source = entry.path();
        let copied = to.join(entry.file_name());
        if source.is_dir() {
            copy(&source, &copied)?;
        } else {
            fs::copy(&source, &copied).map_err(|e| failure(&source, &e))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_folders() -> &'static str {
        if std::env::consts::OS == "linux" {
            ":a:b"
        } else {
            ";a;b"
        }
    }

    #[test]
    fn the_argument_comes_before_the_variable_and_the_standard_folder() {
        let folder = |candidates: Candidates<'_>| candidates.choose().expect("a folder").folder;
        let all = || Candidates {
            argument: Some("argument".into()),
            plugin_path: Some(two_folders()),
            home: Some("home".into()),
            standard_is_writable: true,
        };
        assert_eq!(folder(all()), Path::new("argument"));
        let without_argument = || Candidates {
            argument: None,
            ..all()
        };
        assert_eq!(folder(without_argument()), Path::new("a"));
        let empty_path = Candidates {
            plugin_path: Some(""),
            ..without_argument()
        };
        assert_eq!(folder(empty_path), standard_folder());
        let advice = |candidates: Candidates<'_>| candidates.choose().expect("a folder").advice;
        assert!(advice(all()).contains("No host finds it yet: set OFX_PLUGIN_PATH to argument"));
        assert!(advice(without_argument()).contains("OFX_PLUGIN_PATH of this shell"));
        let standard = Candidates {
            plugin_path: None,
            ..without_argument()
        };
        assert!(advice(standard).contains("Every OpenFX host"));
    }

    #[test]
    fn the_home_folder_comes_with_advice() {
        let candidates = Candidates {
            home: Some("home".into()),
            ..Candidates::default()
        };
        let destination = candidates.choose().expect("a folder");
        let expected = Path::new("home").join("OFX").join("Plugins");
        assert_eq!(destination.folder, expected);
        assert!(destination.advice.contains("OFX_PLUGIN_PATH"));
        assert!(Candidates::default().choose().is_err());
    }

    #[test]
    fn installing_replaces_an_earlier_bundle_as_a_whole() {
        let folder = tempfile::tempdir().expect("a folder");
        let bundle = folder.path().join("built/Seidel.ofx.bundle");
        fs::create_dir_all(bundle.join("Contents/Resources")).expect("a folder");
        fs::write(bundle.join("Contents/Info.plist"), "new").expect("written");
        let to = folder.path().join("plugins");
        let installed = to.join("Seidel.ofx.bundle/Contents");
        fs::create_dir_all(&installed).expect("a folder");
        fs::write(installed.join("stale"), "old").expect("written");
        let report = install(&bundle, Some(to.clone())).expect("installed");
        assert!(report.contains("Seidel.ofx.bundle"));
        let text = fs::read_to_string(installed.join("Info.plist"));
        assert_eq!(text.expect("copied"), "new");
        assert!(!installed.join("stale").exists());
        assert_eq!(fs::read_dir(&to).expect("a folder").count(), 1);
    }
}
