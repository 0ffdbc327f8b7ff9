//! The folders and files of the bundle.

use std::fs;
use std::path::{Path, PathBuf};

use super::{IDENTIFIER, NAME, icon, plist};

/// A platform that a bundle is built for.
#[derive(Debug, PartialEq)]
pub(super) struct Platform {
    /// The bundle's folder for the binary, as OpenFX names it.
    folder: &'static str,
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
            _ if triple.contains("linux") && is_arm => ("Linux-aarch64", "libseidel_ofx.so"),
            _ if triple.contains("linux") => ("Linux-x86-64", "libseidel_ofx.so"),
            // A universal binary made with `lipo` has the same place.
            _ if triple.contains("darwin") => ("MacOS", "libseidel_ofx.dylib"),
            _ if triple.contains("windows") && !is_arm => ("Win64", "seidel_ofx.dll"),
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
}

/// Writes the bundle into `folder`, replacing an earlier one as a whole; returns its path.
///
/// # Errors
/// Files that cannot be read or written. The earlier bundle then stays.
pub(super) fn write(
    folder: &Path,
    platform: &Platform,
    contents: &Contents<'_>,
) -> Result<PathBuf, String> {
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
    for (path, bytes) in [
        (inner.join("Info.plist"), info.as_bytes()),
        (resources.join(format!("{IDENTIFIER}.png")), &icon),
        (
            resources.join("THIRD-PARTY-NOTICES.txt"),
            contents.notices.as_bytes(),
        ),
    ] {
        fs::write(&path, bytes).map_err(|e| failure(&path, &e))?;
    }
    let binary = binaries.join(format!("{NAME}.ofx"));
    fs::copy(contents.binary, &binary).map_err(|e| failure(contents.binary, &e))?;
    replace(&part, &bundle)?;
    Ok(bundle)
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
    fn bundles_have_the_layout_of_openfx() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = folder.path();
        let binary = folder.join("binary");
        let contents = Contents {
            binary: &binary,
            notices: "licences",
        };
        for (triple, expected) in [
            ("x86_64-unknown-linux-gnu", "Linux-x86-64"),
            ("aarch64-apple-darwin", "MacOS"),
            ("x86_64-pc-windows-msvc", "Win64"),
        ] {
            fs::write(&binary, expected).expect("written");
            let platform = Platform::from_triple(triple).expect("a known triple");
            let bundle = write(folder, &platform, &contents).expect("written");
            let inner = bundle.join("Contents");
            let read = |path: &str| fs::read(inner.join(path)).expect(path);
            assert_eq!(read(&format!("{expected}/Seidel.ofx")), expected.as_bytes());
            assert_eq!(read("Resources/THIRD-PARTY-NOTICES.txt"), b"licences");
            assert!(read("Resources/org.seidel.lensblur.png").starts_with(b"\x89PNG"));
            let info = String::from_utf8(read("Info.plist")).expect("text");
            assert!(info.contains("<string>Seidel.ofx</string>"));
            let entries = fs::read_dir(&inner).expect("a folder").count();
            assert_eq!(entries, 3, "the earlier bundle's binary is gone");
        }
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
        };
        assert!(write(folder, &platform, &contents).is_err());
        assert!(earlier.join("mark").exists());
        assert!(Platform::from_triple("wasm32-unknown-unknown").is_err());
    }
}
