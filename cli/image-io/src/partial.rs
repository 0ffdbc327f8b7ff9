//! Partial outputs: files and folders under a temporary name, until they are complete.
//!
//! None remains when a run ends: they are removed when they are dropped, by [`remove_all`] when a signal ends the process,
//! and by the next write of the same output when the process was killed. A partial output is locked while its process
//! lives, so that the outputs of a run that goes on elsewhere are left alone.

use std::collections::{BTreeSet, HashMap};
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use sha2::{Digest, Sha256};
use tempfile::{NamedTempFile, TempDir};

/// First characters of the name of a partial output.
const PREFIX: &str = ".seidel-";

/// Last characters of the name of a partial output.
const SUFFIX: &str = ".part";

/// Attempts to create a partial output that no other run takes for that of a killed one.
const ATTEMPTS: usize = 8;

/// Attempts to remove a partial output when a signal ends the process.
const REMOVALS: usize = 100;

/// Name of the folder that is replaced, within the partial folder.
const OLD: &str = "old";

/// The partial outputs of this process.
#[derive(Default)]
struct Registry {
    /// Those that exist.
    existing: BTreeSet<PathBuf>,
    /// Partial outputs of earlier runs in each folder that was written to, not removed yet.
    found: HashMap<PathBuf, Vec<PathBuf>>,
}

static REGISTRY: LazyLock<Mutex<Registry>> = LazyLock::new(Mutex::default);

fn registry() -> MutexGuard<'static, Registry> {
    REGISTRY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all partial outputs of this process, which must end afterwards: from now on, threads that begin or complete an
/// output wait for ever.
pub fn remove_all() {
    let registry = registry();
    for path in &registry.existing {
        // A thread that still writes into a folder can keep it from being removed. Once it is gone, no file can be added.
        // Best effort: the process ends either way.
        let mut attempts = 0..REMOVALS;
        while path.exists() && attempts.next().is_some() {
            let _ = remove(path);
        }
    }
    std::mem::forget(registry);
}

fn remove(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        fs::remove_dir_all(path)
    } else {
        fs::remove_file(path)
    }
}

/// A file that is not complete yet. It is removed when it is dropped.
pub(crate) struct PartialFile {
    /// `None` once it is complete.
    file: Option<NamedTempFile>,
    path: PathBuf,
}

impl PartialFile {
    /// Creates the partial file of the output at `target`, beside it. Removes those that killed runs left of it.
    pub(crate) fn create(target: &Path) -> io::Result<Self> {
        let stem = stem(target);
        for _ in 0..ATTEMPTS {
            let mut registry = registry();
            registry.remove_stale(target, &stem);
            let mut builder = tempfile::Builder::new();
            builder.prefix(&stem).suffix(SUFFIX);
            // Temporary files are private by default, but the result must be as readable as any new file.
            #[cfg(unix)]
            builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
            let file = builder.tempfile_in(folder_of(target))?;
            let path = file.path().to_path_buf();
            if is_ours(file.as_file(), &path) {
                registry.existing.insert(path.clone());
                let file = Some(file);
                return Ok(Self { file, path });
            }
        }
        Err(io::Error::other("another run removes its temporary file"))
    }

    /// The file, for writing.
    pub(crate) fn as_file_mut(&mut self) -> io::Result<&mut File> {
        let file = self.file.as_mut().map(NamedTempFile::as_file_mut);
        file.ok_or_else(|| ErrorKind::NotFound.into())
    }

    /// Gives the complete file its name.
    pub(crate) fn complete(mut self, target: &Path) -> io::Result<()> {
        // Signals wait until the file has either name.
        let _registry = registry();
        match self.file.take() {
            Some(file) => file.persist(target).map(|_| ()).map_err(|e| e.error),
            None => Ok(()),
        }
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        self.file = None;
        registry().existing.remove(&self.path);
    }
}

/// A folder that is not complete yet. It is removed when it is dropped.
pub(crate) struct PartialFolder {
    /// `None` once it is kept.
    folder: Option<TempDir>,
    path: PathBuf,
    /// Open while the folder exists, for its lock.
    _lock: Option<File>,
}

impl PartialFolder {
    /// Creates the partial folder of the output at `target`, beside it. Removes those that killed runs left of it.
    pub(crate) fn create(target: &Path) -> io::Result<Self> {
        let stem = stem(target);
        let mut registry = registry();
        registry.remove_stale(target, &stem);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&stem).suffix(SUFFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let folder = builder.tempdir_in(folder_of(target))?;
        let path = folder.path().to_path_buf();
        let lock = File::open(&path).ok();
        // Some systems cannot lock folders. Then no other run removes it either.
        let lock = lock.filter(|lock| lock.try_lock().is_ok());
        registry.existing.insert(path.clone());
        Ok(Self {
            folder: Some(folder),
            path,
            _lock: lock,
        })
    }

    /// The path of the folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Replaces `target` by the folder `fresh`, which lies in this one, and keeps the old one until that has succeeded.
    pub(crate) fn replace(self, fresh: &Path, target: &Path) -> Result<(), ReplaceError> {
        // Signals wait until the target is either the old or the new folder.
        let guard = registry();
        let old = self.path.join(OLD);
        fs::rename(target, &old).map_err(ReplaceError::Unchanged)?;
        let Err(error) = fs::rename(fresh, target) else {
            drop(guard);
            return Ok(());
        };
        // The old folder is moved back. If even that fails, it keeps its temporary name.
        if fs::rename(&old, target).is_ok() {
            drop(guard);
            return Err(ReplaceError::Unchanged(error));
        }
        drop(guard);
        self.keep();
        Err(ReplaceError::Moved { error, old })
    }

    /// Leaves the folder where it is.
    fn keep(mut self) {
        if let Some(folder) = self.folder.take() {
            let _ = folder.keep();
        }
    }
}

impl Drop for PartialFolder {
    fn drop(&mut self) {
        self.folder = None;
        registry().existing.remove(&self.path);
    }
}

/// The reason why a folder could not be replaced.
#[derive(Debug)]
pub(crate) enum ReplaceError {
    /// The old folder is as it was.
    Unchanged(io::Error),
    /// The old folder has another name now.
    Moved { error: io::Error, old: PathBuf },
}

impl Registry {
    /// Removes the partial outputs of `target`, whose names begin with `stem`, that killed processes left.
    fn remove_stale(&mut self, target: &Path, stem: &str) {
        let folder = folder_of(target);
        // Each folder is listed once: it may hold a sequence of many thousand frames.
        let found = (self.found.entry(folder.to_path_buf())).or_insert_with(|| listing(folder));
        let is_of_target = |path: &mut PathBuf| {
            let name = path.file_name().unwrap_or_default();
            name.as_encoded_bytes().starts_with(stem.as_bytes())
        };
        for path in found.extract_if(.., is_of_target) {
            // Best effort: what cannot be removed harms no output.
            let _ = remove_if_stale(&path, target);
        }
    }
}

/// Returns the partial outputs in a folder.
fn listing(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let partial = entries.filter(|entry| {
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        name.starts_with(PREFIX.as_bytes()) && name.ends_with(SUFFIX.as_bytes())
    });
    partial.map(|entry| entry.path()).collect()
}

/// Removes a partial output of `target` unless its process lives. A folder whose replacement was cut short is restored.
fn remove_if_stale(path: &Path, target: &Path) -> io::Result<()> {
    let is_folder = fs::symlink_metadata(path)?.is_dir();
    // Some network file systems grant locks only on files that are open for writing.
    let file = File::options().read(true).write(!is_folder).open(path)?;
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Ok(()),
        Err(TryLockError::Error(error)) => return Err(error),
    }
    let old = path.join(OLD);
    if is_folder && old.is_dir() && !target.exists() {
        fs::rename(old, target)?;
    }
    remove(path)
}

/// Locks a new file. Returns whether it still exists, and no other run took it for that of a killed one.
fn is_ours(file: &File, path: &Path) -> bool {
    match file.try_lock() {
        Ok(()) => path.exists(),
        Err(TryLockError::WouldBlock) => false,
        // A file system without locks: other runs cannot lock it either.
        Err(TryLockError::Error(_)) => true,
    }
}

/// Returns the first characters of the names of partial outputs of `target`.
fn stem(target: &Path) -> String {
    let name = target.file_name().unwrap_or(OsStr::new(""));
    let hash = Sha256::digest(name.as_encoded_bytes());
    let hash: String = hash
        .iter()
        .take(4)
        .map(|byte| format!("{byte:02x}"))
        .collect();
    format!("{PREFIX}{hash}-")
}

/// Returns the folder that holds `path`; the current one for a bare name.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_of_killed_runs_are_removed_and_those_of_others_are_not() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("out.exr");
        let killed = folder.path().join(format!("{}killed.part", stem(&target)));
        let living = folder.path().join(format!("{}living.part", stem(&target)));
        let foreign = folder.path().join(".seidel-foreign.part");
        for path in [&killed, &living, &foreign] {
            fs::write(path, "half").expect("writes");
        }
        let lock = File::options().write(true).open(&living).expect("opens");
        lock.try_lock().expect("locks");
        let partial = PartialFile::create(&target).expect("creates");
        assert!(!killed.exists());
        assert!(living.exists() && foreign.exists());
        let own = partial.path.clone();
        assert!(own.exists() && registry().existing.contains(&own));
        // A second run of the same output does not take it for that of a killed one.
        remove_if_stale(&own, &target).expect("left alone");
        assert!(own.exists());
        partial.complete(&target).expect("renames");
        assert!(target.exists() && !own.exists());
        assert!(!registry().existing.contains(&own));
        drop(PartialFile::create(&target).expect("creates"));
        let names = fs::read_dir(folder.path()).expect("lists").count();
        assert_eq!(names, 3, "out.exr, the living and the foreign one");
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_whose_replacement_was_cut_short_is_restored() {
        let parent = tempfile::tempdir().expect("a folder");
        let target = parent.path().join("set");
        let killed = parent.path().join(format!("{}killed.part", stem(&target)));
        fs::create_dir_all(killed.join("old")).expect("creates");
        fs::write(killed.join("old/tile"), "precious").expect("writes");
        let partial = PartialFolder::create(&target).expect("creates");
        assert!(!killed.exists());
        let restored = fs::read_to_string(target.join("tile"));
        assert_eq!(restored.expect("restored"), "precious");
        drop(partial);
        let names = fs::read_dir(parent.path()).expect("lists").count();
        assert_eq!(names, 1, "the target alone");
    }
}
