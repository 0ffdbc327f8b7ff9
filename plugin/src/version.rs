//! Which version of the library this is.

use std::ffi::c_char;

/// Version of the ABI that this header describes. It grows when calls or structs are added, which old callers need not
/// know of; libraries of another one may lack what this header has.
pub const SEIDEL_ABI_VERSION: u32 = 1;

static VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");

/// Version of the ABI that the library speaks: at least SEIDEL_ABI_VERSION for all of this header to be there.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_abi_version() -> u32 {
    crate::guard::guard_or(0, || SEIDEL_ABI_VERSION)
}

/// The library's own version, such as "0.1.0"; the text stays as long as the library is loaded.
#[unsafe(no_mangle)]
pub extern "C" fn seidel_version() -> *const c_char {
    crate::guard::guard_or(std::ptr::null(), || VERSION.as_ptr().cast())
}
