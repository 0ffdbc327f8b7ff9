//! The structs of plugin and host, status codes and geometry: sections "The Generic Core API", "The OfxPlugin Struct",
//! "The OfxHost Struct" and "Status Codes", `ofxCore.h`.

use std::ffi::{c_char, c_int, c_uint, c_void};

use super::Handle;

/// A status code.
pub type OfxStatus = c_int;

/// Success.
pub const STATUS_OK: OfxStatus = 0;
/// Failure.
pub const STATUS_FAILED: OfxStatus = 1;
/// The host lacks a suite that the plugin needs.
pub const STATUS_ERR_MISSING_HOST_FEATURE: OfxStatus = 4;
/// Out of memory.
pub const STATUS_ERR_MEMORY: OfxStatus = 8;
/// An invalid handle.
pub const STATUS_ERR_BAD_HANDLE: OfxStatus = 9;
/// The plugin does not handle the action; the host does what is its default.
pub const STATUS_REPLY_DEFAULT: OfxStatus = 14;
/// An image whose components or sample type the plugin does not support.
pub const STATUS_ERR_IMAGE_FORMAT: OfxStatus = 1000;

/// The main entry point of a plugin or an interact: action, handle, arguments, results.
pub type OfxEntry = unsafe extern "C" fn(*const c_char, *const c_void, Handle, Handle) -> OfxStatus;

/// Receives the host, before any action.
pub type OfxSetHostFn = unsafe extern "C" fn(*mut OfxHost);

/// A plugin of a binary.
#[repr(C)]
pub struct OfxPlugin {
    /// Name of the API.
    pub plugin_api: *const c_char,
    /// Version of the API.
    pub api_version: c_int,
    /// Unique identifier in reverse-DNS notation; projects store it.
    pub plugin_identifier: *const c_char,
    /// Major version: grows when the same parameters give another image.
    pub plugin_version_major: c_uint,
    /// Minor version: grows with compatible changes.
    pub plugin_version_minor: c_uint,
    /// Receives the host.
    pub set_host: Option<OfxSetHostFn>,
    /// Receives the actions.
    pub main_entry: Option<OfxEntry>,
}

// SAFETY: the strings are static, and the struct is never written.
unsafe impl Sync for OfxPlugin {}

/// A host.
#[repr(C)]
pub struct OfxHost {
    /// Property set of the host.
    pub host: Handle,
    /// Returns a suite by name and version, or NULL if the host does not have it.
    pub fetch_suite: Option<unsafe extern "C" fn(Handle, *const c_char, c_int) -> *const c_void>,
}

/// A point; y points up.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct OfxPointD {
    /// Position to the right.
    pub x: f64,
    /// Position upwards.
    pub y: f64,
}

/// A rectangle; y points up.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct OfxRectD {
    /// Left edge.
    pub x1: f64,
    /// Bottom edge.
    pub y1: f64,
    /// Right edge.
    pub x2: f64,
    /// Top edge.
    pub y2: f64,
}

/// A rectangle of pixels; y points up, and the right and top edges are excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct OfxRectI {
    /// Left edge.
    pub x1: c_int,
    /// Bottom edge.
    pub y1: c_int,
    /// Right edge, excluded.
    pub x2: c_int,
    /// Top edge, excluded.
    pub y2: c_int,
}
