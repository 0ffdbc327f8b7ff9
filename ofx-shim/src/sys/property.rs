//! The property suite, and properties of all objects: sections "OfxPropertySuiteV1" and "Properties Reference",
//! `ofxProperty.h` and `ofxCore.h`.

use std::ffi::{CStr, c_char, c_double, c_int, c_void};

use super::{Handle, OfxStatus};

type Set<T> = Option<unsafe extern "C" fn(Handle, *const c_char, c_int, T) -> OfxStatus>;
type SetN<T> = Option<unsafe extern "C" fn(Handle, *const c_char, c_int, *const T) -> OfxStatus>;
type Get<T> = Option<unsafe extern "C" fn(Handle, *const c_char, c_int, *mut T) -> OfxStatus>;

/// The property suite: property set, name, index or count, value.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxPropertySuiteV1 {
    /// Sets a pointer.
    pub set_pointer: Set<*mut c_void>,
    /// Sets a string, which the host copies.
    pub set_string: Set<*const c_char>,
    /// Sets a floating-point number.
    pub set_double: Set<c_double>,
    /// Sets an integer.
    pub set_int: Set<c_int>,
    /// Sets several pointers.
    pub set_pointer_n: SetN<*mut c_void>,
    /// Sets several strings.
    pub set_string_n: SetN<*const c_char>,
    /// Sets several floating-point numbers.
    pub set_double_n: SetN<c_double>,
    /// Sets several integers.
    pub set_int_n: SetN<c_int>,
    /// Gets a pointer.
    pub get_pointer: Get<*mut c_void>,
    /// Gets a string, which is valid until the next call of the host.
    pub get_string: Get<*mut c_char>,
    /// Gets a floating-point number.
    pub get_double: Get<c_double>,
    /// Gets an integer.
    pub get_int: Get<c_int>,
    /// Gets several pointers.
    pub get_pointer_n: Get<*mut c_void>,
    /// Gets several strings.
    pub get_string_n: Get<*mut c_char>,
    /// Gets several floating-point numbers.
    pub get_double_n: Get<c_double>,
    /// Gets several integers.
    pub get_int_n: Get<c_int>,
    /// Resets a property to its default.
    pub reset: Option<unsafe extern "C" fn(Handle, *const c_char) -> OfxStatus>,
    /// Gets the number of values.
    pub dimension: Option<unsafe extern "C" fn(Handle, *const c_char, *mut c_int) -> OfxStatus>,
}

/// The suite's name.
pub const SUITE: &CStr = c"OfxPropertySuite";

/// Name of an object.
pub const NAME: &CStr = c"OfxPropName";
/// Type of the object that changed.
pub const TYPE: &CStr = c"OfxPropType";
/// Value of [`TYPE`]: a clip.
pub const TYPE_CLIP: &CStr = c"OfxTypeClip";
/// Name shown to users.
pub const LABEL: &CStr = c"OfxPropLabel";
/// Short name shown to users.
pub const SHORT_LABEL: &CStr = c"OfxPropShortLabel";
/// Long name shown to users.
pub const LONG_LABEL: &CStr = c"OfxPropLongLabel";
/// Description of the plugin.
pub const PLUGIN_DESCRIPTION: &CStr = c"OfxPropPluginDescription";
/// Version, as several integers.
pub const VERSION: &CStr = c"OfxPropVersion";
/// Time, in frames.
pub const TIME: &CStr = c"OfxPropTime";
/// Reason for an instance-changed action.
pub const CHANGE_REASON: &CStr = c"OfxPropChangeReason";
/// Reason: an edit by the user.
pub const CHANGE_USER_EDITED: &CStr = c"OfxChangeUserEdited";
/// Reason: another time.
pub const CHANGE_TIME: &CStr = c"OfxChangeTime";
/// Effect instance of an interact.
pub const EFFECT_INSTANCE: &CStr = c"OfxPropEffectInstance";
