//! Whole-or-nothing writing: outputs get a temporary name in the same folder and are renamed when they are complete.

use std::fmt::Display;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::error::{FileError, Result};
use crate::partial::{PartialFile, PartialFolder, ReplaceError, folder_of};

/// The buffered, seekable writer that [`write_atomically`] passes to its closure.
pub type Output<'a> = BufWriter<&'a mut File>;

/// Writes a file through `write`. On any error an existing file is unchanged and no temporary file remains.
///
/// A symbolic link is followed, so that its target is replaced and not the link.
///
/// # Errors
/// A missing folder, a target that is not a regular file, an error of `write`, and a full disk.
pub fn write_atomically<E: Display>(
    path: &Path,
    write: impl FnOnce(&mut Output<'_>) -> std::result::Result<(), E>,
) -> Result<()> {
    let target = check_target(path)?;
    let failed = |error: &std::io::Error| FileError::io(path, "be written", error);
    let mut partial = PartialFile::create(&target).map_err(|e| failed(&e))?;
    let file = partial.as_file_mut().map_err(|e| failed(&e))?;
    if let Ok(existing) = fs::metadata(&target) {
        keep_access(file, &existing).map_err(|e| failed(&e))?;
    }
    let mut output = BufWriter::new(&mut *file);
    write(&mut output).map_err(|error| {
        FileError::new(
            path,
            "",
            format!("cannot be written ({error})"),
            "check the free space and the folder; nothing was changed",
        )
    })?;
    output.flush().map_err(|e| failed(&e))?;
    drop(output);
    // Some file systems report a full disk only here.
    file.sync_all().map_err(|e| failed(&e))?;
    partial.complete(&target).map_err(|e| failed(&e))
}

/// Gives a new file the owner, where that is allowed, and the permissions of the file that it replaces.
fn keep_access(file: &File, existing: &fs::Metadata) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        let own = file.metadata()?;
        if (own.uid(), own.gid()) != (existing.uid(), existing.gid()) {
            // Only the superuser may give a file away; a user may at least keep a group that he is in.
            let _ = fchown(file, Some(existing.uid()), Some(existing.gid()))
                .or_else(|_| fchown(file, None, Some(existing.gid())));
        }
    }
    file.set_permissions(existing.permissions())
}

/// Checks, before the work begins, that a file can be written to `path`. Returns its path with links resolved.
///
/// # Errors
/// A missing folder, a target that is not a regular file, and one that is write-protected.
pub fn check_target(path: &Path) -> Result<PathBuf> {
    let target = regular_target(path)?;
    let folder = folder_of(&target);
    if !folder.is_dir() {
        return Err(FileError::new(
            path,
            "",
            format!("its folder {} does not exist", folder.display()),
            "create the folder first or write elsewhere",
        ));
    }
    Ok(target)
}

/// Writes a folder through `write`, which gets the path of an empty temporary folder beside it.
///
/// An existing folder is replaced only if the new one has all of its files, so that no other file is ever lost.
/// Missing parents are created.
///
/// # Errors
/// An error of `write`, a folder with other content, a file of that name, and a full disk. The old folder is then
/// unchanged, and no new one remains.
pub fn write_folder_atomically(path: &Path, write: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    let failed = |error: &std::io::Error| FileError::io(path, "be written", error);
    let target = match fs::canonicalize(path) {
        Ok(existing) if !existing.is_dir() => return Err(not_a_folder(path)),
        Ok(existing) => existing,
        Err(_) => path.to_path_buf(),
    };
    let parent = folder_of(&target).to_path_buf();
    let created = create_parents(&parent).map_err(|e| failed(&e))?;
    let result = write_and_replace(path, &target, write);
    if result.is_err() {
        for folder in created.iter().rev() {
            // Best effort: a parent that is no longer empty remains.
            let _ = fs::remove_dir(folder);
        }
    }
    result
}

/// Checks, before the work begins, that [`write_folder_atomically`] can replace `path` by a folder with the entries
/// `names`.
///
/// # Errors
/// A file of that name, or a folder with other content.
pub fn check_folder_content(path: &Path, names: &[&str]) -> Result<()> {
    let Ok(existing) = fs::metadata(path) else {
        return Ok(());
    };
    if !existing.is_dir() {
        return Err(not_a_folder(path));
    }
    let failed = |error: &std::io::Error| FileError::io(path, "be read", error);
    for entry in fs::read_dir(path).map_err(|e| failed(&e))? {
        let name = entry.map_err(|e| failed(&e))?.file_name();
        if !names.iter().any(|known| name == *known) {
            return Err(foreign_content(path, Path::new(&name)));
        }
    }
    Ok(())
}

fn not_a_folder(path: &Path) -> FileError {
    FileError::new(path, "", "is not a folder", "name a new or empty folder")
}

fn foreign_content(path: &Path, foreign: &Path) -> FileError {
    FileError::new(
        path,
        "",
        format!(
            "already holds `{}`, which is not part of this output",
            foreign.display()
        ),
        "name a new or empty folder",
    )
}

fn write_and_replace(
    path: &Path,
    target: &Path,
    write: impl FnOnce(&Path) -> Result<()>,
) -> Result<()> {
    let failed = |error: &std::io::Error| FileError::io(path, "be written", error);
    let partial = PartialFolder::create(target).map_err(|e| failed(&e))?;
    let fresh = partial.path().join("new");
    fs::create_dir(&fresh).map_err(|e| failed(&e))?;
    // The user knows the folder by its final name.
    write(&fresh).map_err(|error| error.moved(&fresh, path))?;
    if !target.exists() {
        return fs::rename(&fresh, target).map_err(|e| failed(&e));
    }
    if let Some(foreign) = foreign_entry(target, &fresh).map_err(|e| failed(&e))? {
        return Err(foreign_content(path, &foreign));
    }
    partial
        .replace(&fresh, target)
        .map_err(|refused| match refused {
            ReplaceError::Unchanged(error) => failed(&error),
            ReplaceError::Moved { error, old } => FileError::new(
                path,
                "",
                format!("cannot be replaced ({error})"),
                format!("the old folder is now {}", old.display()),
            ),
        })
}

/// Returns the file that a write to `path` replaces or creates, with links resolved.
fn regular_target(path: &Path) -> Result<PathBuf> {
    let Ok(existing) = fs::metadata(path) else {
        if path.file_name().is_none() {
            return Err(FileError::new(
                path,
                "",
                "names no file",
                "give a file name",
            ));
        }
        return Ok(link_target(path));
    };
    if !existing.is_file() {
        return Err(FileError::new(
            path,
            "",
            "exists and is not a regular file",
            "give the name of a new or an ordinary file",
        ));
    }
    if existing.permissions().readonly() {
        return Err(FileError::new(
            path,
            "",
            "exists and is write-protected",
            "make it writable, or give another name",
        ));
    }
    fs::canonicalize(path).map_err(|e| FileError::io(path, "be resolved", &e))
}

/// Returns the file that a write through the link `path` creates; `path` itself if it is no link.
fn link_target(path: &Path) -> PathBuf {
    /// Links to links that systems follow.
    const MAX_LINKS: usize = 40;
    let mut target = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        let Ok(next) = fs::read_link(&target) else {
            break;
        };
        target = folder_of(&target).join(next);
    }
    target
}

/// Creates the missing parents of `folder` and itself. Returns the created folders, outermost first.
fn create_parents(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut missing: Vec<PathBuf> = folder
        .ancestors()
        .take_while(|f| !f.as_os_str().is_empty() && !f.exists())
        .map(Path::to_path_buf)
        .collect();
    missing.reverse();
    fs::create_dir_all(folder)?;
    Ok(missing)
}

/// Returns the first entry of `old`, at any depth, that is missing in `new`.
fn foreign_entry(old: &Path, new: &Path) -> std::io::Result<Option<PathBuf>> {
    for entry in fs::read_dir(old)? {
        let entry = entry?;
        let replacement = new.join(entry.file_name());
        if entry.file_type()?.is_dir() != replacement.is_dir() || !replacement.exists() {
            return Ok(Some(entry.file_name().into()));
        }
        if replacement.is_dir()
            && let Some(inner) = foreign_entry(&entry.path(), &replacement)?
        {
            return Ok(Some(Path::new(&entry.file_name()).join(inner)));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .expect("folder of the test")
            .map(|e| e.expect("entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failing_writer_leaves_the_old_file_unchanged() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("out.bin");
        let half_way = |out: &mut Output<'_>| {
            out.write_all(&[1; 100_000])?;
            out.flush()?;
            Err(std::io::Error::from(std::io::ErrorKind::StorageFull))
        };
        let error = write_atomically(&path, half_way).expect_err("fails midway");
        assert!(error.to_string().contains("out.bin"), "{error}");
        assert!(names(folder.path()).is_empty());

        write_atomically(&path, |out| out.write_all(b"old")).expect("writes");
        write_atomically(&path, half_way).expect_err("fails midway");
        assert_eq!(fs::read(&path).expect("old file"), b"old");
        assert_eq!(names(folder.path()), ["out.bin"]);
        write_atomically(&path, |out| out.write_all(b"new")).expect("writes");
        assert_eq!(fs::read(&path).expect("new file"), b"new");
    }

    #[test]
    fn impossible_targets_are_refused_by_name() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let missing = folder.path().join("no/such/out.bin");
        let error = write_atomically(&missing, |out| out.write_all(b"x")).expect_err("no folder");
        assert!(error.to_string().contains("does not exist"), "{error}");
        let error =
            write_atomically(folder.path(), |out| out.write_all(b"x")).expect_err("a folder");
        assert!(error.to_string().contains("not a regular file"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_are_kept_and_devices_are_refused() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("temporary folder");
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").expect("writes");
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).expect("sets");
        std::os::unix::fs::symlink(&real, &link).expect("links");
        write_atomically(&link, |out| out.write_all(b"new")).expect("writes");
        assert_eq!(fs::read(&real).expect("reads"), b"new");
        assert!(fs::symlink_metadata(&link).expect("link").is_symlink());
        assert_eq!(
            fs::metadata(&real).expect("real").permissions().mode() & 0o777,
            0o640
        );
        assert!(write_atomically(Path::new("/dev/null"), |out| out.write_all(b"x")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn dangling_links_are_followed_and_protected_files_are_refused() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().expect("temporary folder");
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("deep")).expect("creates");
        symlink("second", at("first")).expect("links");
        symlink("deep/real", at("second")).expect("links");
        write_atomically(&at("first"), |out| out.write_all(b"new")).expect("writes");
        assert_eq!(fs::read(at("deep/real")).expect("reads"), b"new");
        assert!(
            fs::symlink_metadata(at("first"))
                .expect("link")
                .is_symlink()
        );
        assert!(
            fs::symlink_metadata(at("second"))
                .expect("link")
                .is_symlink()
        );
        symlink("nowhere/real", at("lost")).expect("links");
        let error = write_atomically(&at("lost"), |out| out.write_all(b"new"));
        let error = error.expect_err("no folder").to_string();
        assert!(error.contains("lost: its folder"), "{error}");

        fs::write(at("kept"), "old").expect("writes");
        fs::set_permissions(at("kept"), fs::Permissions::from_mode(0o444)).expect("sets");
        let error = write_atomically(&at("kept"), |out| out.write_all(b"new"));
        let error = error.expect_err("protected").to_string();
        assert!(
            error.contains("kept: exists and is write-protected; make it"),
            "{error}"
        );
        assert_eq!(fs::read(at("kept")).expect("reads"), b"old");
    }

    #[test]
    fn folders_are_written_completely_or_not_at_all() {
        let root = tempfile::tempdir().expect("temporary folder");
        let target = root.path().join("deep/set");
        let put = |name: &'static str, text: &'static str| {
            move |at: &Path| {
                fs::write(at.join(name), text).map_err(|e| FileError::io(at, "be written", &e))
            }
        };
        let fails = |at: &Path| {
            put("half", "x")(at)?;
            Err(FileError::new(at, "", "no more space", "free some"))
        };
        let error = write_folder_atomically(&target, fails).expect_err("fails midway");
        assert_eq!(error.file(), target, "the name that the user gave");
        assert!(names(root.path()).is_empty());

        write_folder_atomically(&target, put("a", "1")).expect("new");
        write_folder_atomically(&target, fails).expect_err("fails midway");
        assert_eq!(fs::read_to_string(target.join("a")).expect("kept"), "1");
        write_folder_atomically(&target, put("a", "2")).expect("same names: replaced");
        assert_eq!(fs::read_to_string(target.join("a")).expect("new"), "2");

        fs::write(target.join("mine"), "precious").expect("writes");
        let error = write_folder_atomically(&target, put("a", "3")).expect_err("foreign file");
        assert!(error.to_string().contains("`mine`"), "{error}");
        let early = check_folder_content(&target, &["a"]).expect_err("foreign file");
        assert_eq!(early, error);
        check_folder_content(&target, &["a", "mine"]).expect("known files");
        check_folder_content(&root.path().join("nothing"), &["a"]).expect("nothing is in the way");
        check_folder_content(&target.join("mine"), &["a"]).expect_err("a file");
        assert_eq!(fs::read_to_string(target.join("a")).expect("kept"), "2");
        assert_eq!(names(&root.path().join("deep")), ["set"]);
        let empty = root.path().join("empty");
        fs::create_dir(&empty).expect("creates");
        write_folder_atomically(&empty, put("b", "1")).expect("into an empty folder");
        assert_eq!(names(&empty), ["b"]);
    }
}
