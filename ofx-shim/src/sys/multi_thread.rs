//! The multi-thread suite, as far as how many processors a host allows; its threads and mutexes are not used.

use std::ffi::{CStr, c_uint, c_void};

use super::OfxStatus;

/// Version 1. What is not used is left without its type.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxMultiThreadSuiteV1 {
    /// Not used.
    pub multi_thread: *const c_void,
    /// How many processors there are to work on.
    pub num_cpus: Option<unsafe extern "C" fn(*mut c_uint) -> OfxStatus>,
    /// Not used: the index of a thread, whether it is one, and five functions of mutexes.
    pub others: [*const c_void; 7],
}

/// Name of the suite.
pub const SUITE: &CStr = c"OfxMultiThreadSuite";
