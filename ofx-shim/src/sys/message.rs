//! The message suite. Texts are formats as of `printf`: always give `%s` and the text.

use std::ffi::{CStr, c_char};

use super::{Handle, OfxStatus};

/// Says something: handle, kind, identifier, format and what goes in it.
pub type Message = Option<
    unsafe extern "C" fn(Handle, *const c_char, *const c_char, *const c_char, ...) -> OfxStatus,
>;

/// Version 1.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxMessageSuiteV1 {
    /// Says it at once.
    pub message: Message,
}

/// Version 2.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxMessageSuiteV2 {
    /// Says it at once.
    pub message: Message,
    /// Says it until it is taken back.
    pub set_persistent: Message,
    /// Takes it back.
    pub clear_persistent: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
}

/// Name of the suite.
pub const SUITE: &CStr = c"OfxMessageSuite";
/// Something to know.
pub const MESSAGE: &CStr = c"OfxMessageMessage";
/// For the log alone.
pub const LOG: &CStr = c"OfxMessageLog";
/// Something went wrong.
pub const ERROR: &CStr = c"OfxMessageError";
/// Something may go wrong.
pub const WARNING: &CStr = c"OfxMessageWarning";
