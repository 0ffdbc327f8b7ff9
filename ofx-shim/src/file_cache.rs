//! Values read from files, cached until the files change. All instances share them.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use crate::host::Result;

/// Modification time and length of a file, by which a change is noticed; `None` if they are unknown.
type Stamp = Option<(SystemTime, u64)>;

fn stamp_of(file: &Path) -> Stamp {
    let metadata = std::fs::metadata(file).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}

struct Entry<V> {
    stamp: Stamp,
    reloads: i32,
    value: Arc<V>,
}

/// Number of entries at which a new one empties the cache. A project uses a few.
const CAPACITY: usize = 32;

/// A cache of values read from files.
pub(crate) struct FileCache<K, V>(Mutex<BTreeMap<K, Entry<V>>>);

impl<K: Ord + Clone, V> FileCache<K, V> {
    /// Creates an empty cache.
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<K, Entry<V>>> {
        // No code panics halfway through a change of the map.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the value of `key`, and calls `read` for it if it is not cached, if its `file` has changed, or if `reloads`
    /// differs from that of the cached value.
    ///
    /// # Errors
    /// Those of `read`. An older value does not take the place of one that cannot be read.
    pub(crate) fn get(
        &self,
        key: &K,
        file: Option<&Path>,
        reloads: i32,
        read: impl FnOnce() -> Result<V>,
    ) -> Result<Arc<V>> {
        let stamp = file.and_then(stamp_of);
        if let Some(entry) = self.lock().get(key) {
            let is_current = entry.stamp == stamp && entry.reloads == reloads && stamp.is_some();
            if is_current || file.is_none() {
                return Ok(Arc::clone(&entry.value));
            }
        }
        // Read without the lock, which other renders may need meanwhile.
        let value = Arc::new(read()?);
        let entry = Entry {
            stamp,
            reloads,
            value: Arc::clone(&value),
        };
        let removed = {
            let mut entries = self.lock();
            let is_full = entries.len() >= CAPACITY && !entries.contains_key(key);
            let all = if is_full {
                std::mem::take(&mut *entries)
            } else {
                BTreeMap::new()
            };
            (all, entries.insert(key.clone(), entry))
        };
        // Values are dropped without the lock.
        drop(removed);
        Ok(value)
    }

    /// Empties the cache. Values in use live on until they are dropped.
    pub(crate) fn clear(&self) {
        let removed = std::mem::take(&mut *self.lock());
        drop(removed);
    }
}
