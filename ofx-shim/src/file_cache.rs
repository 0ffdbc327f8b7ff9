//! Things read from files, kept for as long as the files stay as they are. All instances share them.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use crate::host::Result;

/// What tells a file that was changed: when, and its length.
type Stamp = Option<(SystemTime, u64)>;

fn stamp_of(file: &Path) -> Stamp {
    let about = std::fs::metadata(file).ok()?;
    Some((about.modified().ok()?, about.len()))
}

struct Kept<V> {
    stamp: Stamp,
    reloads: i32,
    value: Arc<V>,
}

/// Things that are kept. More than these are read again.
const MOST: usize = 32;

/// Things by what they were read from.
pub(crate) struct Shelf<K, V>(Mutex<BTreeMap<K, Kept<V>>>);

impl<K: Ord + Clone, V> Shelf<K, V> {
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(BTreeMap::new()))
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<K, Kept<V>>> {
        // The map is whole wherever a thread may have died.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What `key` stands for; `read` again where its `file` is another than it was, or where `reloads` is.
    ///
    /// # Errors
    /// Those of `read`; what was read before is not given in its place.
    pub(crate) fn get(
        &self,
        key: &K,
        file: Option<&Path>,
        reloads: i32,
        read: impl FnOnce() -> Result<V>,
    ) -> Result<Arc<V>> {
        let stamp = file.and_then(stamp_of);
        if let Some(kept) = self.lock().get(key) {
            let same = kept.stamp == stamp && kept.reloads == reloads && stamp.is_some();
            if same || file.is_none() {
                return Ok(Arc::clone(&kept.value));
            }
        }
        // Without the lock: others go on meanwhile.
        let value = Arc::new(read()?);
        let kept = Kept {
            stamp,
            reloads,
            value: Arc::clone(&value),
        };
        let gone = {
            let mut all = self.lock();
            let full = all.len() >= MOST && !all.contains_key(key);
            let gone = if full {
                std::mem::take(&mut *all)
            } else {
                BTreeMap::new()
            };
            (gone, all.insert(key.clone(), kept))
        };
        // What nobody holds ends outside the lock.
        drop(gone);
        Ok(value)
    }

    /// Lets go of all; what is in use lives on until it is not.
    pub(crate) fn forget(&self) {
        let gone = std::mem::take(&mut *self.lock());
        drop(gone);
    }
}
