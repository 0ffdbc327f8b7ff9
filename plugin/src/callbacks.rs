//! How a caller is told of progress, and asked whether to go on.

use std::ffi::c_void;

use crate::pointers::Sized64;

/// Called with `user` and the share done, 0 to 1, about fifty times a second, always on the thread that called the
/// library. Whatever is not 0 stops the work. It must return, not throw or jump.
pub type SeidelProgress = Option<unsafe extern "C" fn(user: *mut c_void, share: f64) -> i32>;

/// What is called back while a call works.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SeidelCallbacks {
    /// sizeof(SeidelCallbacks).
    pub size: u64,
    /// Handed back as it is.
    pub user: *mut c_void,
    /// May be NULL.
    pub progress: SeidelProgress,
}

// SAFETY: `repr(C)`, begins with its size; a pointer and a nullable function that only the caller vouches for.
unsafe impl Sized64 for SeidelCallbacks {
    const LEAST: usize = size_of::<Self>();

    fn neutral() -> Self {
        Self {
            size: size_of::<Self>() as u64,
            user: std::ptr::null_mut(),
            progress: None,
        }
    }
}

impl SeidelCallbacks {
    /// Tells the share done; whether to go on.
    pub(crate) fn tell(&self, share: f64) -> bool {
        match self.progress {
            None => true,
            // SAFETY: the caller vouches for the function, and that it may be called with `user` until the call ends.
            Some(progress) => unsafe { progress(self.user, share) == 0 },
        }
    }
}
