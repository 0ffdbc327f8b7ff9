//! The message suite: sections "OfxMessageSuiteV1" and "OfxMessageSuiteV2", `ofxMessage.h`.
//!
//! Messages are formats of `printf`: pass the text with each `%` doubled, and no argument.

use std::ffi::{CStr, c_char};

use super::{Handle, OfxStatus};

/// Shows a message: effect, type, identifier, format, and the values of the format.
pub type Message = Option<
    unsafe extern "C" fn(Handle, *const c_char, *const c_char, *const c_char, ...) -> OfxStatus,
>;

/// Version 1 of the message suite.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxMessageSuiteV1 {
    /// Shows a message once.
    pub message: Message,
}

/// Version 2 of the message suite.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxMessageSuiteV2 {
    /// Shows a message once.
    pub message: Message,
    /// Shows a message until it is cleared.
    pub set_persistent: Message,
    /// Clears the persistent message of an effect.
    pub clear_persistent: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
}

/// The suite's name.
pub const SUITE: &CStr = c"OfxMessageSuite";
/// Message type: information.
pub const MESSAGE: &CStr = c"OfxMessageMessage";
/// Message type: for the host's log only.
pub const LOG: &CStr = c"OfxMessageLog";
/// Message type: warning.
pub const WARNING: &CStr = c"OfxMessageWarning";
/// Message type: error.
pub const ERROR: &CStr = c"OfxMessageError";
