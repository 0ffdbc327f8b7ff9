//! Versions of the ABI and of the library.

use std::ffi::c_char;

use crate::panics::guard_or;

/// Version of the ABI that this header describes. It grows when functions, structs or members are added; existing
/// ones do not change, so that a program runs with any library of its own ABI version or a later one.
pub const SEIDEL_ABI_VERSION: u32 = 1;

static VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");

/// Returns the ABI version of the loaded library. If it is less than SEIDEL_ABI_VERSION, functions of this header may
/// be missing.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_abi_version() -> u32 {
    guard_or(0, || SEIDEL_ABI_VERSION)
}

/// Returns the version of the library, such as "0.1.0". The string belongs to the library and is valid while it is
/// loaded.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_version() -> *const c_char {
    guard_or(std::ptr::null(), || VERSION.as_ptr().cast())
}
