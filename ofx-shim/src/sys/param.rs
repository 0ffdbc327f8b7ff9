//! The parameter suite, and names of types and properties of parameters.

use std::ffi::{CStr, c_char, c_double, c_int, c_uint, c_void};

use super::{Handle, OfxStatus};

/// Parameters of effects. Functions of keys are not used.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxParameterSuiteV1 {
    /// Declares one by type and name; gives its properties.
    pub define: Option<
        unsafe extern "C" fn(Handle, *const c_char, *const c_char, *mut Handle) -> OfxStatus,
    >,
    /// One of an instance, and its properties.
    pub handle:
        Option<unsafe extern "C" fn(Handle, *const c_char, *mut Handle, *mut Handle) -> OfxStatus>,
    /// Properties of all together.
    pub set_property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Properties of one.
    pub property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Its value now; not for renders.
    pub value: Option<unsafe extern "C" fn(Handle, ...) -> OfxStatus>,
    /// Its value at a time.
    pub value_at_time: Option<unsafe extern "C" fn(Handle, c_double, ...) -> OfxStatus>,
    /// Not used.
    pub derivative: *const c_void,
    /// Not used.
    pub integral: *const c_void,
    /// Sets its value; not in renders.
    pub set_value: Option<unsafe extern "C" fn(Handle, ...) -> OfxStatus>,
    /// Sets its value at a time; not in renders.
    pub set_value_at_time: Option<unsafe extern "C" fn(Handle, c_double, ...) -> OfxStatus>,
    /// How many keys it has.
    pub key_count: Option<unsafe extern "C" fn(Handle, *mut c_uint) -> OfxStatus>,
    /// Not used: four functions of keys, and to copy.
    pub keys: [*const c_void; 5],
    /// What follows until its end is one step to undo.
    pub edit_begin: Option<unsafe extern "C" fn(Handle, *const c_char) -> OfxStatus>,
    /// The end.
    pub edit_end: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
}

/// A whole number, as parameters have it.
pub type Int = c_int;

/// Name of the suite.
pub const SUITE: &CStr = c"OfxParameterSuite";

/// Type: whole number.
pub const TYPE_INTEGER: &CStr = c"OfxParamTypeInteger";
/// Type: number.
pub const TYPE_DOUBLE: &CStr = c"OfxParamTypeDouble";
/// Type: two numbers.
pub const TYPE_DOUBLE_2D: &CStr = c"OfxParamTypeDouble2D";
/// Type: switch.
pub const TYPE_BOOLEAN: &CStr = c"OfxParamTypeBoolean";
/// Type: one of several.
pub const TYPE_CHOICE: &CStr = c"OfxParamTypeChoice";
/// Type: text.
pub const TYPE_STRING: &CStr = c"OfxParamTypeString";
/// Type: several together.
pub const TYPE_GROUP: &CStr = c"OfxParamTypeGroup";
/// Type: a page of several.
pub const TYPE_PAGE: &CStr = c"OfxParamTypePage";
/// Type: something to press.
pub const TYPE_PUSH_BUTTON: &CStr = c"OfxParamTypePushButton";

/// Whether it has keys.
pub const ANIMATES: &CStr = c"OfxParamPropAnimates";
/// Whether projects keep it.
pub const PERSISTENT: &CStr = c"OfxParamPropPersistant";
/// Whether pictures depend on it.
pub const EVALUATE_ON_CHANGE: &CStr = c"OfxParamPropEvaluateOnChange";
/// Whether it is not shown.
pub const SECRET: &CStr = c"OfxParamPropSecret";
/// Whether it can be changed.
pub const ENABLED: &CStr = c"OfxParamPropEnabled";
/// What it does.
pub const HINT: &CStr = c"OfxParamPropHint";
/// Its name in scripts.
pub const SCRIPT_NAME: &CStr = c"OfxParamPropScriptName";
/// The group it is in.
pub const PARENT: &CStr = c"OfxParamPropParent";
/// Whether a group is open.
pub const GROUP_OPEN: &CStr = c"OfxParamPropGroupOpen";
/// What is on a page.
pub const PAGE_CHILD: &CStr = c"OfxParamPropPageChild";
/// Default value.
pub const DEFAULT: &CStr = c"OfxParamPropDefault";
/// Least value.
pub const MIN: &CStr = c"OfxParamPropMin";
/// Largest value.
pub const MAX: &CStr = c"OfxParamPropMax";
/// Least value of a slider.
pub const DISPLAY_MIN: &CStr = c"OfxParamPropDisplayMin";
/// Largest value of a slider.
pub const DISPLAY_MAX: &CStr = c"OfxParamPropDisplayMax";
/// Step of a slider.
pub const INCREMENT: &CStr = c"OfxParamPropIncrement";
/// Decimals shown.
pub const DIGITS: &CStr = c"OfxParamPropDigits";
/// What numbers mean.
pub const DOUBLE_TYPE: &CStr = c"OfxParamPropDoubleType";
/// A position.
pub const DOUBLE_TYPE_XY_ABSOLUTE: &CStr = c"OfxParamDoubleTypeXYAbsolute";
/// No more than numbers.
pub const DOUBLE_TYPE_PLAIN: &CStr = c"OfxParamDoubleTypePlain";
/// In what defaults are given.
pub const DEFAULT_COORDINATES: &CStr = c"OfxParamPropDefaultCoordinateSystem";
/// In canonical coordinates.
pub const COORDINATES_CANONICAL: &CStr = c"OfxParamCoordinatesCanonical";
/// Whether the host draws a handle for it.
pub const HOST_OVERLAY_HANDLE: &CStr = c"kOfxParamPropUseHostOverlayHandle";
/// Names of what can be chosen.
pub const CHOICE_OPTION: &CStr = c"OfxParamPropChoiceOption";
/// What a text is.
pub const STRING_MODE: &CStr = c"OfxParamPropStringMode";
/// A line of words.
pub const STRING_SINGLE_LINE: &CStr = c"OfxParamStringIsSingleLine";
/// The path of a file.
pub const STRING_FILE_PATH: &CStr = c"OfxParamStringIsFilePath";
/// Whether the file is there already.
pub const FILE_PATH_EXISTS: &CStr = c"OfxParamPropStringFilePathExists";
