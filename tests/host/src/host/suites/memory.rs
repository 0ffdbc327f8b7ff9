//! The memory suite, and blocks of memory.

use std::ffi::c_void;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::memory::OfxMemorySuiteV1;

use super::pointers::put;
use crate::host::{Object, current, locked};

/// Memory of the host that a plugin works in.
pub(crate) struct Block {
    at: *mut u128,
    words: usize,
}

// SAFETY: the host does not touch what is in it.
unsafe impl Send for Block {}
// SAFETY: as above.
unsafe impl Sync for Block {}

impl Block {
    /// Of so many bytes, none of them 0.
    pub(crate) fn new(bytes: usize) -> Self {
        let words = bytes.div_ceil(16).max(1);
        let mut memory = std::mem::ManuallyDrop::new(vec![u128::MAX; words].into_boxed_slice());
        Self {
            at: memory.as_mut_ptr(),
            words,
        }
    }

    /// Where it is.
    pub(crate) fn data(&self) -> *mut c_void {
        self.at.cast()
    }
}

impl Drop for Block {
    fn drop(&mut self) {
        // SAFETY: from a box of so many words, freed here alone.
        drop(unsafe { Vec::from_raw_parts(self.at, self.words, self.words) });
    }
}

pub(super) fn suite() -> OfxMemorySuiteV1 {
    OfxMemorySuiteV1 {
        memoryAlloc: Some(memory_alloc),
        memoryFree: Some(memory_free),
    }
}

unsafe extern "C" fn memory_alloc(
    _effect: *mut c_void,
    bytes: usize,
    at: *mut *mut c_void,
) -> OfxStatus {
    let Some(host) = current() else {
        return kOfxStatFailed;
    };
    let block = Arc::new(Block::new(bytes));
    let data = block.data();
    let handle = host.keep("a block of memory", Object::Block(block));
    locked(&host.blocks).insert(data as usize, handle);
    host.counts.memory_out.fetch_add(1, Ordering::SeqCst);
    // SAFETY: the plugin gives room for a pointer.
    unsafe { put(at, data, "memoryAlloc") }
}

unsafe extern "C" fn memory_free(at: *mut c_void) -> OfxStatus {
    let Some(host) = current() else {
        return kOfxStatFailed;
    };
    let handle = locked(&host.blocks).remove(&(at as usize));
    match handle {
        Some(handle) => {
            host.end(handle);
            host.counts.memory_out.fetch_sub(1, Ordering::SeqCst);
            kOfxStatOK
        }
        None => {
            host.misused("memoryFree was given what is not allocated".to_owned());
            kOfxStatErrBadHandle
        }
    }
}
