//! The memory suite, and memory blocks.

use std::ffi::c_void;
use std::mem::ManuallyDrop;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use openfx::sys::generic::core::*;
use openfx::sys::image_effect_v1::memory::OfxMemorySuiteV1;

use super::pointers::{with_host, write_result};
use crate::host::{Object, locked};

/// Memory that the host allocates for a plugin, aligned to 16 bytes.
pub(crate) struct MemoryBlock {
    memory: *mut u128,
    words: usize,
}

// SAFETY: the host never accesses the contents.
unsafe impl Send for MemoryBlock {}
// SAFETY: as above.
unsafe impl Sync for MemoryBlock {}

impl MemoryBlock {
    /// Allocates at least `bytes`, none of which is 0.
    pub(crate) fn new(bytes: usize) -> Self {
        let words = bytes.div_ceil(16).max(1);
        let mut memory = ManuallyDrop::new(vec![u128::MAX; words].into_boxed_slice());
        Self {
            memory: memory.as_mut_ptr(),
            words,
        }
    }

    pub(crate) fn data(&self) -> *mut c_void {
        self.memory.cast()
    }
}

impl Drop for MemoryBlock {
    fn drop(&mut self) {
        // SAFETY: the memory is that of a boxed slice of this length, and is freed here only.
        drop(unsafe { Vec::from_raw_parts(self.memory, self.words, self.words) });
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
    memory: *mut *mut c_void,
) -> OfxStatus {
    with_host(|host| {
        let block = Arc::new(MemoryBlock::new(bytes));
        let data = block.data();
        let handle = host.register("a memory block", Object::MemoryBlock(block));
        locked(&host.blocks).insert(data as usize, handle);
        host.counters.memory_held.fetch_add(1, Ordering::SeqCst);
        // SAFETY: the plugin provides memory for a pointer.
        unsafe { write_result(memory, data, "memoryAlloc") }
    })
}

unsafe extern "C" fn memory_free(memory: *mut c_void) -> OfxStatus {
    with_host(|host| {
        let handle = locked(&host.blocks).remove(&(memory as usize));
        let Some(handle) = handle else {
            host.record_misuse("memoryFree was given memory that is not allocated");
            return kOfxStatErrBadHandle;
        };
        host.invalidate(handle);
        host.counters.memory_held.fetch_sub(1, Ordering::SeqCst);
        kOfxStatOK
    })
}
