//! Handles: numbers that lead nowhere when followed, never given twice, so that stale ones are told from wrong ones.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use super::effect::{Clip, Effect, Parameter, ParameterSet};
use super::locked;
use super::properties::PropertySet;
use super::suites::{Block, Lock, Overlay};

/// What a handle may stand for.
#[derive(Clone)]
pub(crate) enum Object {
    Properties(Arc<PropertySet>),
    Effect(Arc<Effect>),
    Clip(Arc<Clip>),
    Parameters(Arc<ParameterSet>),
    Parameter(Arc<Parameter>),
    Block(Arc<Block>),
    Lock(Arc<Lock>),
    Overlay(Arc<Overlay>),
}

/// A kind of object.
pub(crate) trait Kept: Sized {
    fn of(object: &Object) -> Option<Arc<Self>>;
}

macro_rules! kept {
    ($($kind:ident($type:ty)),*) => {$(
        impl Kept for $type {
            fn of(object: &Object) -> Option<Arc<Self>> {
                match object {
                    Object::$kind(found) => Some(Arc::clone(found)),
                    _ => None,
                }
            }
        }
    )*};
}

kept!(
    Properties(PropertySet),
    Effect(Effect),
    Clip(Clip),
    Parameters(ParameterSet),
    Parameter(Parameter),
    Block(Block),
    Lock(Lock),
    Overlay(Overlay)
);

/// No address of a program on a 64-bit machine; to follow it is a crash.
const FIRST: usize = if usize::BITS == 64 {
    0x5eed_u64.rotate_left(48) as usize
} else {
    16
};

static NEXT: AtomicUsize = AtomicUsize::new(FIRST + 16);

#[derive(Default)]
pub(super) struct Objects {
    all: Mutex<HashMap<usize, (String, Option<Object>)>>,
}

impl Objects {
    pub(super) fn keep(&self, name: &str, object: Object) -> usize {
        let handle = NEXT.fetch_add(16, Ordering::SeqCst);
        locked(&self.all).insert(handle, (name.to_owned(), Some(object)));
        handle
    }

    pub(super) fn end(&self, handle: usize) -> bool {
        let ended = (locked(&self.all).get_mut(&handle)).and_then(|entry| entry.1.take());
        // Dropped here, when nothing is locked.
        ended.is_some()
    }

    pub(super) fn find(&self, handle: usize) -> Result<Object, String> {
        match locked(&self.all).get(&handle) {
            Some((_, Some(object))) => Ok(object.clone()),
            Some((name, None)) => Err(format!("a handle of {name} that is no longer valid")),
            None if handle == 0 => Err("a NULL handle".to_owned()),
            None => Err("what is no handle of this host".to_owned()),
        }
    }
}
