//! Results kept from one render to the next.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Results of renders, known by a hash of all that they were made from: the [fingerprint] of the plate and the part that was
/// rendered. A host that asks for the same render with another mix or mask then needs no render.
///
/// The results that were used last stay, up to a number of them and of bytes.
///
/// [fingerprint]: crate::LensSession::fingerprint
#[derive(Debug)]
pub struct ResultStore<T> {
    max_count: usize,
    max_bytes: usize,
    /// The results used last are at the front.
    kept: Mutex<VecDeque<Kept<T>>>,
}

#[derive(Debug)]
struct Kept<T> {
    key: u64,
    bytes: usize,
    result: Arc<T>,
}

impl<T> ResultStore<T> {
    /// Creates an empty store that keeps `max_count` results of at most `max_bytes` bytes together.
    pub const fn new(max_count: usize, max_bytes: usize) -> Self {
        Self {
            max_count,
            max_bytes,
            kept: Mutex::new(VecDeque::new()),
        }
    }

    /// Returns the result that was kept as `key`.
    pub fn get(&self, key: u64) -> Option<Arc<T>> {
        let mut kept = self.lock();
        let place = kept.iter().position(|other| other.key == key)?;
        let entry = kept.remove(place)?;
        let result = Arc::clone(&entry.result);
        kept.push_front(entry);
        Some(result)
    }

    /// Keeps a `result` of `bytes` bytes as `key`, and drops the results used longest ago. A result that is larger than the
    /// store is not kept.
    pub fn insert(&self, key: u64, bytes: usize, result: Arc<T>) {
        let mut kept = self.lock();
        kept.retain(|other| other.key != key);
        if bytes > self.max_bytes {
            return;
        }
        kept.push_front(Kept { key, bytes, result });
        kept.truncate(self.max_count);
        let mut sum = 0;
        kept.retain(|other| {
            sum += other.bytes;
            sum <= self.max_bytes
        });
    }

    /// Drops all results.
    pub fn clear(&self) {
        self.lock().clear();
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Kept<T>>> {
        // No code panics halfway through a change of the queue.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_results_used_last_stay() {
        let store = ResultStore::new(9, 100);
        for key in 0..3 {
            store.insert(key, 40, Arc::new(key));
        }
        assert!(store.get(0).is_none() && store.get(2).is_some());
        assert_eq!(store.get(1).as_deref(), Some(&1));
        // Key 1 was used last.
        store.insert(3, 40, Arc::new(3));
        assert!(store.get(2).is_none() && store.get(1).is_some());
        store.insert(1, 60, Arc::new(7));
        assert_eq!(store.get(1).as_deref(), Some(&7));
        store.clear();
        assert!(store.get(1).is_none());
    }

    #[test]
    fn small_results_do_not_pile_up() {
        let store = ResultStore::new(2, 100);
        for key in 0..3 {
            store.insert(key, 1, Arc::new(key));
        }
        assert!(store.get(0).is_none() && store.get(1).is_some() && store.get(2).is_some());
    }

    #[test]
    fn results_larger_than_the_store_are_not_kept() {
        let store = ResultStore::new(9, 100);
        store.insert(1, 40, Arc::new(1));
        store.insert(2, 101, Arc::new(2));
        assert!(store.get(2).is_none() && store.get(1).is_some());
    }
}
