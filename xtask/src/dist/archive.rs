//! The archive: files in the order of their names with one fixed time, so that equal files make an equal archive.

use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Name of the list of checksums within the archive, in the form that `sha256sum --check` reads.
const SUMS: &str = "SHA256SUMS";

/// The permissions of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// Read by all.
    Text,
    /// Run by all.
    Program,
}

impl Mode {
    fn unix(self) -> u32 {
        match self {
            Self::Text => 0o644,
            Self::Program => 0o755,
        }
    }
}

/// A file of the archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Entry {
    /// Path in the archive, with `/` between folders.
    path: String,
    bytes: Vec<u8>,
    mode: Mode,
}

/// A written archive.
pub(super) struct Archive {
    pub(super) path: PathBuf,
    pub(super) bytes: usize,
    pub(super) files: usize,
    pub(super) sha256: String,
}

impl Entry {
    pub(super) fn text(path: &str, text: String) -> Self {
        Self {
            path: path.to_owned(),
            bytes: text.into_bytes(),
            mode: Mode::Text,
        }
    }

    /// Reads the file `from`, which gets the path `to` in the archive.
    pub(super) fn read(from: &Path, to: &str, mode: Mode) -> Result<Self, String> {
        let bytes = fs::read(from).map_err(|e| format!("{}: {e}", from.display()))?;
        Ok(Self {
            path: to.to_owned(),
            bytes,
            mode,
        })
    }

    /// Returns whether the path of the file in the archive contains `name`.
    pub(super) fn is_about(&self, name: &str) -> bool {
        self.path.contains(name)
    }

    /// Reads all files below the folder `from`, which becomes `to` in the archive. Files of a plugin's binary folder are
    /// programs.
    pub(super) fn read_folder(from: &Path, to: &str) -> Result<Vec<Self>, String> {
        let listed = fs::read_dir(from).map_err(|e| format!("{}: {e}", from.display()))?;
        let mut entries = Vec::new();
        for item in listed.flatten() {
            let name = item.file_name().to_string_lossy().into_owned();
            let within = format!("{to}/{name}");
            if item.path().is_dir() {
                entries.extend(Self::read_folder(&item.path(), &within)?);
            } else {
                let mode = if name.ends_with(".ofx") {
                    Mode::Program
                } else {
                    Mode::Text
                };
                entries.push(Self::read(&item.path(), &within, mode)?);
            }
        }
        Ok(entries)
    }
}

/// Writes `entries` and their checksums as `folder/name.zip`, all below a folder `name`, and the checksum of the archive
/// beside it.
///
/// # Errors
/// Two entries of one path, and files that cannot be written.
pub(super) fn write(folder: &Path, name: &str, mut entries: Vec<Entry>) -> Result<Archive, String> {
    entries.sort_by(|a, b| a.path.cmp(&b.path));
    if let Some(pair) = entries.windows(2).find(|pair| pair[0].path == pair[1].path) {
        return Err(format!("{} is in the archive twice", pair[0].path));
    }
    let sums: String = (entries.iter())
        .map(|entry| format!("{}  {}\n", sha256(&entry.bytes), entry.path))
        .collect();
    entries.push(Entry::text(SUMS, sums));
    let bytes = zipped(name, &entries).map_err(|e| format!("{name}.zip: {e}"))?;
    let path = folder.join(format!("{name}.zip"));
    let sha256 = sha256(&bytes);
    let beside = folder.join(format!("{name}.zip.sha256"));
    write_whole(&path, &bytes)?;
    write_whole(&beside, format!("{sha256}  {name}.zip\n").as_bytes())?;
    Ok(Archive {
        path,
        bytes: bytes.len(),
        files: entries.len(),
        sha256,
    })
}

fn zipped(name: &str, entries: &[Entry]) -> zip::result::ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for entry in entries {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .unix_permissions(entry.mode.unix());
        zip.start_file(format!("{name}/{}", entry.path), options)?;
        zip.write_all(&entry.bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// Writes a file under a temporary name and renames it.
fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let unfinished = path.with_extension("unfinished");
    let written = fs::write(&unfinished, bytes).and_then(|()| fs::rename(&unfinished, path));
    written.map_err(|e| {
        // Nothing half-written stays behind.
        let _ = fs::remove_file(&unfinished);
        format!("{}: {e}", path.display())
    })
}

fn sha256(bytes: &[u8]) -> String {
    let hash = Sha256::digest(bytes);
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    fn entries() -> Vec<Entry> {
        vec![
            Entry {
                mode: Mode::Program,
                ..Entry::text("bin/seidel", "a program".to_owned())
            },
            Entry::text("README.md", "words".to_owned()),
        ]
    }

    #[test]
    fn equal_files_make_an_equal_archive() {
        let folder = tempfile::tempdir().expect("a folder");
        let first = write(folder.path(), "seidel", entries()).expect("written");
        let bytes = fs::read(&first.path).expect("readable");
        let reversed = entries().into_iter().rev().collect();
        let second = write(folder.path(), "seidel", reversed).expect("written");
        assert_eq!(
            (first.sha256, bytes),
            (second.sha256, fs::read(&second.path).expect("readable"))
        );
        let twice = [entries(), entries()].concat();
        assert!(write(folder.path(), "twice", twice).is_err());
        let names = fs::read_dir(folder.path()).expect("a folder").flatten();
        let mut names: Vec<_> = names
            .map(|n| n.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        assert_eq!(names, ["seidel.zip", "seidel.zip.sha256"]);
    }

    #[test]
    fn checksums_and_permissions_are_those_of_the_files() {
        let folder = tempfile::tempdir().expect("a folder");
        let written = write(folder.path(), "seidel", entries()).expect("written");
        let file = fs::File::open(&written.path).expect("readable");
        let mut zip = zip::ZipArchive::new(file).expect("an archive");
        let names = zip
            .file_names()
            .map(|name| name.expect("a name").into_owned());
        let names: Vec<String> = names.collect();
        assert_eq!(
            names,
            ["seidel/README.md", "seidel/bin/seidel", "seidel/SHA256SUMS"]
        );
        let mut text = |name: &str| {
            let mut text = String::new();
            let mut entry = zip.by_name(name).expect("an entry");
            entry.read_to_string(&mut text).expect("text");
            (text, entry.unix_mode().map(|mode| mode & 0o777))
        };
        let (sums, _) = text("seidel/SHA256SUMS");
        for line in sums.lines() {
            let (hash, path) = line.split_once("  ").expect("a hash and a path");
            let (content, mode) = text(&format!("seidel/{path}"));
            assert_eq!(hash, sha256(content.as_bytes()), "{path}");
            assert_eq!(mode, Some(if path == "bin/seidel" { 0o755 } else { 0o644 }));
        }
        let beside = fs::read_to_string(folder.path().join("seidel.zip.sha256")).expect("written");
        assert_eq!(beside, format!("{}  seidel.zip\n", written.sha256));
    }
}
