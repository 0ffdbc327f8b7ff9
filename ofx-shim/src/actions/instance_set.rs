//! A set of instances.

use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::sys::Handle;

/// A set of instances, known by the addresses of their handles.
pub(super) struct InstanceSet(Mutex<BTreeSet<usize>>);

impl InstanceSet {
    pub(super) const fn new() -> Self {
        Self(Mutex::new(BTreeSet::new()))
    }

    pub(super) fn insert(&self, instance: Handle) {
        self.lock().insert(instance.addr());
    }

    /// Removes an instance; returns whether it was in the set.
    pub(super) fn remove(&self, instance: Handle) -> bool {
        self.lock().remove(&instance.addr())
    }

    fn lock(&self) -> MutexGuard<'_, BTreeSet<usize>> {
        // No code panics halfway through a change of the set.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
