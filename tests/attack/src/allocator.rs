//! A global allocator that counts bytes and ends the process beyond a bound.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Exit status of a process that went beyond the bound.
pub(crate) const OVER_BOUND: i32 = 86;

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

fn add(bytes: usize) {
    let before = USED.fetch_add(bytes, Relaxed);
    if before.saturating_add(bytes) > LIMIT.load(Relaxed) {
        // SAFETY: ends the process at once, without destructors, which might allocate.
        unsafe { libc::_exit(OVER_BOUND) }
    }
}

// SAFETY: every call is passed on to the system's allocator with its own arguments; the counters touch no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: the caller's promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promises.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        // SAFETY: the caller's promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        add(size);
        USED.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller's promises.
        unsafe { System.realloc(at, layout, size) }
    }
}
