//! The folders of a bundle.

use std::fs;
use std::path::{Path, PathBuf};

use super::{NAME, icon, plist};

/// Identifier of the plugin; its icon is called after it.
const IDENTIFIER: &str = "org.seidel.lensblur";

/// A platform that a bundle is for.
#[derive(Debug, PartialEq)]
pub(super) struct Platform {
    /// Folder of its binary.
    folder: &'static str,
    /// File that cargo builds.
    pub(super) library: &'static str,
}

impl Platform {
    /// That of a target triple.
    pub(super) fn of(triple: &str) -> Result<Self, String> {
        let arm = triple.starts_with("aarch64");
        let (folder, library) = match triple {
            _ if triple.contains("linux") && arm => ("Linux-aarch64", "libseidel_ofx.so"),
            _ if triple.contains("linux") => ("Linux-x86-64", "libseidel_ofx.so"),
            // One binary for both kinds of processor, put together by `lipo`, would lie here as well.
            _ if triple.contains("darwin") => ("MacOS", "libseidel_ofx.dylib"),
            _ if triple.contains("windows") && !arm => ("Win64", "seidel_ofx.dll"),
            _ => {
                return Err(format!(
                    "{triple}: OpenFX has no folder for it; there are Linux, macOS and 64-bit Windows"
                ));
            }
        };
        Ok(Self { folder, library })
    }
}

/// Puts a bundle in `folder` in place of the one that was there, whole or not at all.
pub(super) fn lay_out(
    folder: &Path,
    binary: &Path,
    platform: &Platform,
) -> Result<PathBuf, String> {
    let part = folder.join(format!("{NAME}.ofx.bundle.part"));
    let bundle = folder.join(format!("{NAME}.ofx.bundle"));
    remove(&part)?;
    let contents = part.join("Contents");
    let place = contents.join(platform.folder);
    let resources = contents.join("Resources");
    for new in [&place, &resources] {
        fs::create_dir_all(new).map_err(|e| failed(new, &e))?;
    }
    let version = env!("CARGO_PKG_VERSION");
    let info = contents.join("Info.plist");
    fs::write(&info, plist::plist(NAME, version)).map_err(|e| failed(&info, &e))?;
    let picture = resources.join(format!("{IDENTIFIER}.png"));
    fs::write(&picture, icon::icon()).map_err(|e| failed(&picture, &e))?;
    let to = place.join(format!("{NAME}.ofx"));
    fs::copy(binary, &to).map_err(|e| failed(binary, &e))?;
    replace(&part, &bundle)?;
    Ok(bundle)
}

/// Puts the folder `new` in the place of `old`, which goes only then.
pub(super) fn replace(new: &Path, old: &Path) -> Result<(), String> {
    let aside = old.with_extension("old");
    remove(&aside)?;
    if old.exists() {
        fs::rename(old, &aside).map_err(|e| failed(old, &e))?;
    }
    if let Err(error) = fs::rename(new, old) {
        // What was there stays, as far as that can be.
        let _ = fs::rename(&aside, old);
        return Err(failed(old, &error));
    }
    remove(&aside)
}

/// Removes a folder if it is there.
pub(super) fn remove(folder: &Path) -> Result<(), String> {
    match folder.exists() {
        true => fs::remove_dir_all(folder).map_err(|e| failed(folder, &e)),
        false => Ok(()),
    }
}

pub(super) fn failed(path: &Path, error: &std::io::Error) -> String {
    format!(
        "{}: {error}; check the folder and its permissions",
        path.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bundles_are_laid_out_as_hosts_look_for_them() {
        let folder = std::env::temp_dir().join(format!("seidel-bundle-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        let binary = folder.join("binary");
        for (triple, own) in [
            ("x86_64-unknown-linux-gnu", "Linux-x86-64"),
            ("aarch64-apple-darwin", "MacOS"),
            ("x86_64-pc-windows-msvc", "Win64"),
        ] {
            fs::write(&binary, own).expect("written");
            let platform = Platform::of(triple).expect("known");
            let bundle = lay_out(&folder, &binary, &platform).expect("laid out");
            let contents = bundle.join("Contents");
            let inside = fs::read_to_string(contents.join(own).join("Seidel.ofx"));
            assert_eq!(inside.expect("the binary"), own);
            let info = fs::read_to_string(contents.join("Info.plist")).expect("a plist");
            assert!(info.contains("<string>Seidel.ofx</string>"));
            let icon = fs::read(contents.join("Resources/org.seidel.lensblur.png"));
            assert!(icon.expect("an icon").starts_with(b"\x89PNG"));
            let folders = fs::read_dir(&contents).expect("read").count();
            assert_eq!(folders, 3, "nothing is left of the one before");
        }
        // Without a binary the bundle stays as it was.
        let platform = Platform::of("x86_64-unknown-linux-gnu").expect("known");
        assert!(lay_out(&folder, &folder.join("none"), &platform).is_err());
        assert!(
            folder
                .join("Seidel.ofx.bundle/Contents/Win64/Seidel.ofx")
                .exists()
        );
        assert!(Platform::of("wasm32-unknown-unknown").is_err());
        fs::remove_dir_all(&folder).expect("removed");
    }
}
