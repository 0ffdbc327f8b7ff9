//! A global allocator that counts bytes and refuses more than a bound.
//!
//! A refusal ends the process, unless the caller only tries whether memory is there: readers do that before they believe
//! a header.

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr::null_mut;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Rust's words on stderr when an allocation was refused.
pub(crate) const REFUSED: &str = "memory allocation of ";

/// The bound of memory over that at the start of a case, bytes.
pub(crate) const BOUND_BYTES: usize = 1 << 30;

static USED: AtomicUsize = AtomicUsize::new(0);
static LIMIT: AtomicUsize = AtomicUsize::new(usize::MAX);

struct Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Sets the bound from the memory that is in use now.
pub(crate) fn begin_case() {
    LIMIT.store(USED.load(Relaxed).saturating_add(BOUND_BYTES), Relaxed);
}

/// Counts `bytes` more; returns whether they are within the bound.
fn add(bytes: usize) -> bool {
    let before = USED.fetch_add(bytes, Relaxed);
    let is_within = before.saturating_add(bytes) <= LIMIT.load(Relaxed);
    if !is_within {
        USED.fetch_sub(bytes, Relaxed);
    }
    is_within
}

// SAFETY: every call is passed on to the system's allocator with its own arguments, or refused as it may refuse it; the
// counters touch no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if !add(layout.size()) {
            return null_mut();
        }
        // SAFETY: the caller's promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promises.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if !add(layout.size()) {
            return null_mut();
        }
        // SAFETY: the caller's promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if !add(size) {
            return null_mut();
        }
        USED.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promises.
        unsafe { System.realloc(at, layout, size) }
    }
}
