//! The folders and files of the bundle.

use std::fs;
use std::path::{Path, PathBuf};

use super::{IDENTIFIER, NAME, icon, plist};

/// The folders of OpenFX for the binaries of each platform.
const FOLDERS: [&str; 4] = [LINUX, LINUX_ARM, MACOS, WINDOWS];
const LINUX: &str = "Linux-x86-64";
const LINUX_ARM: &str = "Linux-aarch64";
/// A universal binary made with `lipo` has the same place.
const MACOS: &str = "MacOS";
const WINDOWS: &str = "Win64";

/// A platform that a bundle is built for.
#[derive(Debug, PartialEq)]
pub(super) struct Platform {
    /// The bundle's folder for the binary.
    pub(super) folder: &'static str,
    /// The file that cargo builds.
    pub(super) library: &'static str,
}

impl Platform {
    /// The platform of a target triple.
    ///
    /// # Errors
    /// A triple that OpenFX has no folder for.
    pub(super) fn from_triple(triple: &str) -> Result<Self, String> {
        let is_arm = triple.starts_with("aarch64");
        let (folder, library) = match triple {
            _ if triple.contains("linux") && is_arm => (LINUX_ARM, "libseidel_ofx.so"),
            _ if triple.contains("linux") => (LINUX, "libseidel_ofx.so"),
            _ if triple.contains("darwin") => (MACOS, "libseidel_ofx.dylib"),
            _ if triple.contains("windows") && !is_arm => (WINDOWS, "seidel_ofx.dll"),
            _ => {
                return Err(format!(
                    "{triple}: OpenFX has no folder for this platform; build for Linux, macOS or 64-bit Windows"
                ));
            }
        };
        Ok(Self { folder, library })
    }
}

/// The parts of a bundle that are built elsewhere.
pub(super) struct Contents<'a> {
    /// The plugin's library.
    pub(super) binary: &'a Path,
    /// Licences of the libraries in it.
    pub(super) notices: &'a str,
    /// Name and text of the project's own licences.
    pub(super) licences: &'a [(&'a str, String)],
}

/// A bundle that was written.
#[derive(Debug)]
pub(super) struct Bundle {
    pub(super) path: PathBuf,
    /// Folders of the platforms that it has of an earlier run.
    pub(super) kept: Vec<&'static str>,
}

/// Returns the name of the notices of the binary in `folder`.
fn notices_name(folder: &str) -> String {
    format!("THIRD-PARTY-NOTICES.{folder}.txt")
}

/// Writes the bundle into `folder`, replacing an earlier one as a whole. Other platforms of an earlier bundle of the same version
/// are kept.
///
/// # Errors
/// Files that cannot be read or written. The earlier bundle then stays.
pub(super) fn write(
    folder: &Path,
    platform: &Platform,
    contents: &Contents<'_>,
) -> Result<Bundle, String> {
    let part = folder.join(format!("{NAME}.ofx.bundle.part"));
    let bundle = folder.join(format!("{NAME}.ofx.bundle"));
    remove(&part)?;
    let inner = part.join("Contents");
    let binaries = inner.join(platform.folder);
    let resources = inner.join("Resources");
    for new in [&binaries, &resources] {
        fs::create_dir_all(new).map_err(|e| failure(new, &e))?;
    }
    let info = plist::text(env!("CARGO_PKG_VERSION"));
    let icon = icon::png();
    let notices = notices_name(platform.folder);
    let own = contents.licences.iter();
    let own = own.map(|(name, text)| (resources.join(name), text.as_bytes()));
    let files = [
        (inner.join("Info.plist"), info.as_bytes()),
        (resources.join(format!("{IDENTIFIER}.png")), &icon),
        (resources.join(notices), contents.notices.as_bytes()),
    ];
    for (path, bytes) in files.into_iter().chain(own) {
        fs::write(&path, bytes).map_err(|e| failure(&path, &e))?;
    }
    let binary = binaries.join(format!("{NAME}.ofx"));
    fs::copy(contents.binary, &binary).map_err(|e| failure(contents.binary, &e))?;
    let kept = keep_others(&bundle, &part, platform, &info)?;
    replace(&part, &bundle)?;
    Ok(Bundle { path: bundle, kept })
}

/// Copies the binaries and notices of other platforms from the bundle `from` to `to` if its `Info.plist` is `info`; returns
/// their folders.
fn keep_others(
    from: &Path,
    to: &Path,
    platform: &Platform,
    info: &str,
) -> Result<Vec<&'static str>, String> {
    let (from, to) = (from.join("Contents"), to.join("Contents"));
    let mut kept = Vec::new();
    if fs::read_to_string(from.join("Info.plist")).is_ok_and(|own| own == info) {
        for folder in FOLDERS {
            let notices = Path::new("Resources").join(notices_name(folder));
            let binary = Path::new(folder).join(format!("{NAME}.ofx"));
            let is_whole = [&notices, &binary]
                .iter()
                .all(|file| from.join(file).is_file());
            if folder == platform.folder || !is_whole {
                continue;
            }
            let made = to.join(folder);
            fs::create_dir_all(&made).map_err(|e| failure(&made, &e))?;
            for file in [notices, binary] {
                fs::copy(from.join(&file), to.join(&file))
                    .map_err(|e| failure(&from.join(&file), &e))?;
            }
            kept.push(folder);
        }
    }
    Ok(kept)
}

/// Moves the folder `new` to `old`. The folder that was there is removed last.
pub(super) fn replace(new: &Path, old: &Path) -> Result<(), String> {
    let aside = old.with_extension("old");
    remove(&aside)?;
    if old.exists() {
        fs::rename(old, &aside).map_err(|e| failure(old, &e))?;
    }
    if let Err(error) = fs::rename(new, old) {
        // The first error is the one to report, whether or not the old folder can be restored.
        let _ = fs::rename(&aside, old);
        return Err(failure(old, &error));
    }
    remove(&aside)
}

/// Removes a folder if it exists.
pub(super) fn remove(folder: &Path) -> Result<(), String> {
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(|e| failure(folder, &e))?;
    }
    Ok(())
}

/// A message about a path that could not be read or written.
pub(super) fn failure(path: &Path, error: &std::io::Error) -> String {
    format!(
        "{}: {error}; check that the path exists and its permissions",
        path.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bundles_have_the_layout_of_openfx_and_keep_other_platforms() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let binary = folder.join("binary");
        let inner = folder.join("Seidel.ofx.bundle/Contents");
        let read = |path: &str| fs::read(inner.join(path)).expect(path);
        let triples = [
            ("x86_64-unknown-linux-gnu", "Linux-x86-64"),
            ("aarch64-apple-darwin", "MacOS"),
            ("x86_64-pc-windows-gnu", "Win64"),
        ];
        for (at, (triple, expected)) in triples.into_iter().enumerate() {
            fs::write(&binary, expected).expect("written");
            let contents = Contents {
                binary: &binary,
                notices: expected,
                licences: &[("LICENSE-MIT", "ours".to_owned())],
            };
            let platform = Platform::from_triple(triple).expect("a known triple");
            let bundle = write(folder, &platform, &contents).expect("written");
            assert_eq!(bundle.kept, triples.map(|(_, name)| name)[..at]);
            for (_, name) in &triples[..=at] {
                assert_eq!(read(&format!("{name}/Seidel.ofx")), name.as_bytes());
                let notices = format!("Resources/THIRD-PARTY-NOTICES.{name}.txt");
                assert_eq!(read(&notices), name.as_bytes());
            }
            assert_eq!(read("Resources/LICENSE-MIT"), b"ours");
            assert!(read("Resources/org.seidel.lensblur.png").starts_with(b"\x89PNG"));
            let info = String::from_utf8(read("Info.plist")).expect("text");
            assert!(info.contains("<string>Seidel.ofx</string>"));
        }
        // Binaries of another version are not mixed with this one.
        fs::write(inner.join("Info.plist"), plist::text("0.0.1")).expect("written");
        let contents = Contents {
            binary: &binary,
            notices: "",
            licences: &[],
        };
        let platform = Platform::from_triple("x86_64-pc-windows-gnu").expect("a known triple");
        let bundle = write(folder, &platform, &contents).expect("written");
        assert!(bundle.kept.is_empty() && !inner.join("MacOS").exists());
    }

    #[test]
    fn without_a_binary_the_earlier_bundle_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let earlier = folder.join("Seidel.ofx.bundle");
        fs::create_dir(&earlier).expect("a folder");
        fs::write(earlier.join("mark"), "").expect("written");
        let platform = Platform::from_triple("x86_64-unknown-linux-gnu").expect("a known triple");
        let contents = Contents {
            binary: &folder.join("none"),
            notices: "",
            licences: &[],
        };
        assert!(write(folder, &platform, &contents).is_err());
        assert!(earlier.join("mark").exists());
        assert!(Platform::from_triple("wasm32-unknown-unknown").is_err());
    }
}
