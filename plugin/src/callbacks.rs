//! Progress and cancellation.

use std::ffi::c_void;

use crate::pointers::Versioned;

/// Progress callback. It gets `user` of SeidelCallbacks and the share of the work done, from 0 to 1 and never
/// decreasing. The library calls it at the start, about every 10 ms and at the end, always on the thread that made
/// the call. Return 0 to go on. Any other value before the end stops the work: the call then returns
/// SEIDEL_STATUS_ABORTED within 100 ms. The callback may call the library. It must return normally: no exception and
/// no longjmp.
pub type SeidelProgress = Option<unsafe extern "C" fn(user: *mut c_void, share: f64) -> i32>;

/// Callbacks of a call.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelCallbacks {
    /// sizeof(SeidelCallbacks).
    pub size: u64,
    /// Passed to `progress` unchanged.
    pub user: *mut c_void,
    /// May be NULL.
    pub progress: SeidelProgress,
}

// SAFETY: `repr(C)`, begins with its size, and holds a pointer and a nullable function that only the caller
// guarantees.
unsafe impl Versioned for SeidelCallbacks {
    const MIN_SIZE: usize = size_of::<Self>();

    fn defaults() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            user: std::ptr::null_mut(),
            progress: None,
        }
    }
}

impl SeidelCallbacks {
    /// Reports the share done; returns whether to go on.
    pub(crate) fn report(&self, share: f64) -> bool {
        match self.progress {
            None => true,
            // SAFETY: the caller guarantees that the function may be called with `user` until the call ends.
            Some(progress) => unsafe { progress(self.user, share) == 0 },
        }
    }
}
