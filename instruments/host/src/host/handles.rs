//! Handles: unique numbers that crash when dereferenced, so that stale and invalid handles can be distinguished.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use super::effect::{Clip, Effect, Parameter, ParameterSet};
use super::locked;
use super::properties::PropertySet;
use super::suites::{MemoryBlock, Overlay, RecursiveMutex};

/// An object that a handle stands for.
#[derive(Clone)]
pub(crate) enum Object {
    Properties(Arc<PropertySet>),
    Effect(Arc<Effect>),
    Clip(Arc<Clip>),
    Parameters(Arc<ParameterSet>),
    Parameter(Arc<Parameter>),
    MemoryBlock(Arc<MemoryBlock>),
    Mutex(Arc<RecursiveMutex>),
    Overlay(Arc<Overlay>),
}

/// A type that handles can stand for.
pub(crate) trait HandleTarget: Sized {
    /// Returns the object if it is of this type.
    fn downcast(object: &Object) -> Option<Arc<Self>>;
}

macro_rules! handle_targets {
    ($($kind:ident($type:ty)),*) => {$(
        impl HandleTarget for $type {
            fn downcast(object: &Object) -> Option<Arc<Self>> {
                match object {
                    Object::$kind(found) => Some(Arc::clone(found)),
                    _ => None,
                }
            }
        }
    )*};
}

handle_targets!(
    Properties(PropertySet),
    Effect(Effect),
    Clip(Clip),
    Parameters(ParameterSet),
    Parameter(Parameter),
    MemoryBlock(MemoryBlock),
    Mutex(RecursiveMutex),
    Overlay(Overlay)
);

/// The start of handle values. On 64-bit machines it is no valid address of a program, so dereferencing crashes.
const FIRST: usize = if usize::BITS == 64 {
    0x5eed_u64.rotate_left(48) as usize
} else {
    16
};

static NEXT: AtomicUsize = AtomicUsize::new(FIRST + 16);

/// The handle of an object that keeps it itself; 0 until it is set.
#[derive(Debug, Default)]
pub(crate) struct OwnHandle(OnceLock<usize>);

impl OwnHandle {
    pub(crate) fn get(&self) -> usize {
        self.0.get().copied().unwrap_or(0)
    }

    /// Sets the handle once; later calls have no effect.
    pub(crate) fn set(&self, handle: usize) {
        let _ = self.0.set(handle);
    }
}

/// All handles ever given to plugins. Handles are not reused.
#[derive(Default)]
pub(super) struct HandleTable {
    entries: Mutex<HashMap<usize, Entry>>,
}

struct Entry {
    /// Describes the object in messages.
    name: String,
    /// `None` once the handle is invalid.
    object: Option<Object>,
}

impl HandleTable {
    /// Returns a new handle of `object`.
    pub(super) fn register(&self, name: &str, object: Object) -> usize {
        let handle = NEXT.fetch_add(16, Ordering::SeqCst);
        let entry = Entry {
            name: name.to_owned(),
            object: Some(object),
        };
        locked(&self.entries).insert(handle, entry);
        handle
    }

    /// Invalidates a handle. Returns whether it was valid.
    pub(super) fn invalidate(&self, handle: usize) -> bool {
        let object = (locked(&self.entries).get_mut(&handle)).and_then(|entry| entry.object.take());
        // The object is dropped here, after the lock is released.
        object.is_some()
    }

    /// Returns the object of a handle, or a description of the invalid handle.
    pub(super) fn find(&self, handle: usize) -> Result<Object, String> {
        match locked(&self.entries).get(&handle) {
            Some(Entry {
                object: Some(object),
                ..
            }) => Ok(object.clone()),
            Some(Entry { name, .. }) => Err(format!("an invalidated handle of {name}")),
            None if handle == 0 => Err("a NULL handle".to_owned()),
            None => Err("an unknown handle".to_owned()),
        }
    }
}
