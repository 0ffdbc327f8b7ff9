//! The multi-thread suite: section "OfxMultiThreadSuiteV1", `ofxMultiThread.h`. Only its number of CPUs is used.

use std::ffi::{CStr, c_uint, c_void};

use super::OfxStatus;

/// The multi-thread suite. Functions that are not used have no type.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxMultiThreadSuiteV1 {
    /// Runs a function on several threads: not used.
    pub multi_thread: *const c_void,
    /// Gets the number of CPUs that the plugin may use.
    pub num_cpus: Option<unsafe extern "C" fn(*mut c_uint) -> OfxStatus>,
    /// Thread index, whether a thread is spawned, and five functions of mutexes: not used.
    pub others: [*const c_void; 7],
}

/// The suite's name.
pub const SUITE: &CStr = c"OfxMultiThreadSuite";
