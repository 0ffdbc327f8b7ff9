//! The property suite, and names of properties of anything.

use std::ffi::{CStr, c_char, c_double, c_int, c_void};

use super::{Handle, OfxStatus};

type Set<T> = Option<unsafe extern "C" fn(Handle, *const c_char, c_int, T) -> OfxStatus>;
type SetN<T> = Option<unsafe extern "C" fn(Handle, *const c_char, c_int, *const T) -> OfxStatus>;
type Get<T> = Option<unsafe extern "C" fn(Handle, *const c_char, c_int, *mut T) -> OfxStatus>;

/// Reads and writes the properties of an object: handle, name, index or count, value.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxPropertySuiteV1 {
    /// Sets a pointer.
    pub set_pointer: Set<*mut c_void>,
    /// Sets a text, which the host copies.
    pub set_string: Set<*const c_char>,
    /// Sets a number.
    pub set_double: Set<c_double>,
    /// Sets a whole number.
    pub set_int: Set<c_int>,
    /// Sets several.
    pub set_pointer_n: SetN<*mut c_void>,
    /// Sets several.
    pub set_string_n: SetN<*const c_char>,
    /// Sets several.
    pub set_double_n: SetN<c_double>,
    /// Sets several.
    pub set_int_n: SetN<c_int>,
    /// Gets a pointer.
    pub get_pointer: Get<*mut c_void>,
    /// Gets a text, good until the next call.
    pub get_string: Get<*mut c_char>,
    /// Gets a number.
    pub get_double: Get<c_double>,
    /// Gets a whole number.
    pub get_int: Get<c_int>,
    /// Gets several.
    pub get_pointer_n: Get<*mut c_void>,
    /// Gets several.
    pub get_string_n: Get<*mut c_char>,
    /// Gets several.
    pub get_double_n: Get<c_double>,
    /// Gets several.
    pub get_int_n: Get<c_int>,
    /// Back to the default.
    pub reset: Option<unsafe extern "C" fn(Handle, *const c_char) -> OfxStatus>,
    /// How many values there are.
    pub dimension: Option<unsafe extern "C" fn(Handle, *const c_char, *mut c_int) -> OfxStatus>,
}

/// Name of the suite.
pub const SUITE: &CStr = c"OfxPropertySuite";

/// What an object is.
pub const TYPE: &CStr = c"OfxPropType";
/// Its name.
pub const NAME: &CStr = c"OfxPropName";
/// Its name for users.
pub const LABEL: &CStr = c"OfxPropLabel";
/// The same, short.
pub const SHORT_LABEL: &CStr = c"OfxPropShortLabel";
/// The same, long.
pub const LONG_LABEL: &CStr = c"OfxPropLongLabel";
/// What a plugin does.
pub const PLUGIN_DESCRIPTION: &CStr = c"OfxPropPluginDescription";
/// Version, several numbers.
pub const VERSION: &CStr = c"OfxPropVersion";
/// Version of the API that a host speaks.
pub const API_VERSION: &CStr = c"OfxPropAPIVersion";
/// A frame.
pub const TIME: &CStr = c"OfxPropTime";
/// Who changed something.
pub const CHANGE_REASON: &CStr = c"OfxPropChangeReason";
/// The user did.
pub const CHANGE_USER_EDITED: &CStr = c"OfxChangeUserEdited";
/// The plugin did, or the project was loaded.
pub const CHANGE_PLUGIN_EDITED: &CStr = c"OfxChangePluginEdited";
/// Time went on.
pub const CHANGE_TIME: &CStr = c"OfxChangeTime";
/// The plugin's own data of an instance.
pub const INSTANCE_DATA: &CStr = c"OfxPropInstanceData";
/// The instance that an interact is of.
pub const EFFECT_INSTANCE: &CStr = c"OfxPropEffectInstance";
/// Where the bundle is.
pub const PLUGIN_FILE_PATH: &CStr = c"OfxPluginPropFilePath";
/// Kind of object: a parameter.
pub const TYPE_PARAMETER: &CStr = c"OfxTypeParameter";
/// Kind of object: a clip.
pub const TYPE_CLIP: &CStr = c"OfxTypeClip";
