//! What a binary exports, and what its host is.

use std::ffi::{c_char, c_int, c_uint, c_void};

use super::Handle;

/// What a call answers: 0 is success.
pub type OfxStatus = c_int;

/// Done.
pub const STATUS_OK: OfxStatus = 0;
/// Not done.
pub const STATUS_FAILED: OfxStatus = 1;
/// Not done, and nothing will be.
pub const STATUS_ERR_FATAL: OfxStatus = 2;
/// A property or suite that is not known.
pub const STATUS_ERR_UNKNOWN: OfxStatus = 3;
/// The host lacks what the plugin cannot do without.
pub const STATUS_ERR_MISSING_HOST_FEATURE: OfxStatus = 4;
/// A handle that is none.
pub const STATUS_ERR_BAD_HANDLE: OfxStatus = 9;
/// Memory ran out.
pub const STATUS_ERR_MEMORY: OfxStatus = 8;
/// The plugin leaves it to the host.
pub const STATUS_REPLY_DEFAULT: OfxStatus = 14;
/// A picture is other than what was agreed.
pub const STATUS_ERR_IMAGE_FORMAT: OfxStatus = 1000;

/// The main entry of a plugin, and the entry of an interact: action, handle, arguments in and out.
pub type OfxEntry = unsafe extern "C" fn(*const c_char, *const c_void, Handle, Handle) -> OfxStatus;

/// Called by the host with itself before anything else.
pub type OfxSetHostFn = unsafe extern "C" fn(*mut OfxHost);

/// A plugin of a binary.
#[repr(C)]
pub struct OfxPlugin {
    /// Which API it speaks.
    pub plugin_api: *const c_char,
    /// Its version.
    pub api_version: c_int,
    /// Reverse-DNS name, never changed.
    pub plugin_identifier: *const c_char,
    /// Grows when pictures change.
    pub plugin_version_major: c_uint,
    /// Grows with repairs.
    pub plugin_version_minor: c_uint,
    /// Gets the host.
    pub set_host: Option<OfxSetHostFn>,
    /// Gets the actions.
    pub main_entry: Option<OfxEntry>,
}

// SAFETY: its texts are static and nothing in it changes.
unsafe impl Sync for OfxPlugin {}

/// A host.
#[repr(C)]
pub struct OfxHost {
    /// Properties of the host.
    pub host: Handle,
    /// Gives a suite by name and version, NULL where there is none.
    pub fetch_suite: Option<unsafe extern "C" fn(Handle, *const c_char, c_int) -> *const c_void>,
}

/// A point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct OfxPointD {
    /// To the right.
    pub x: f64,
    /// Up.
    pub y: f64,
}

/// A rectangle; y runs up.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct OfxRectD {
    /// Left.
    pub x1: f64,
    /// Bottom.
    pub y1: f64,
    /// Right.
    pub x2: f64,
    /// Top.
    pub y2: f64,
}

/// A rectangle of pixels; y runs up, the second corner is beyond the last pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct OfxRectI {
    /// Left.
    pub x1: c_int,
    /// Bottom.
    pub y1: c_int,
    /// Right.
    pub x2: c_int,
    /// Top.
    pub y2: c_int,
}
