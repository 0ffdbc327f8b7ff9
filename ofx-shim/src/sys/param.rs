//! The parameter suite, and types and properties of parameters: sections "Effect Parameters" and "OfxParameterSuiteV1",
//! `ofxParam.h`.

use std::ffi::{CStr, c_char, c_double, c_uint, c_void};

use super::{Handle, OfxStatus};

/// The parameter suite. Functions that are not used have no type.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxParameterSuiteV1 {
    /// Defines a parameter by type and name and gets its property set.
    pub define: Option<
        unsafe extern "C" fn(Handle, *const c_char, *const c_char, *mut Handle) -> OfxStatus,
    >,
    /// Gets a parameter by name, and its property set.
    pub handle:
        Option<unsafe extern "C" fn(Handle, *const c_char, *mut Handle, *mut Handle) -> OfxStatus>,
    /// Gets the property set of the parameter set.
    pub set_property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Gets the property set of a parameter.
    pub property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
    /// Gets the current value; not in renders.
    pub value: Option<unsafe extern "C" fn(Handle, ...) -> OfxStatus>,
    /// Gets the value at a time.
    pub value_at_time: Option<unsafe extern "C" fn(Handle, c_double, ...) -> OfxStatus>,
    /// Gets the derivative at a time: not used.
    pub derivative: *const c_void,
    /// Gets the integral over a time range: not used.
    pub integral: *const c_void,
    /// Sets the current value; not in renders.
    pub set_value: Option<unsafe extern "C" fn(Handle, ...) -> OfxStatus>,
    /// Sets the value at a time; not in renders.
    pub set_value_at_time: Option<unsafe extern "C" fn(Handle, c_double, ...) -> OfxStatus>,
    /// Gets the number of keyframes.
    pub key_count: Option<unsafe extern "C" fn(Handle, *mut c_uint) -> OfxStatus>,
    /// Four functions of keyframes, and `paramCopy`: not used.
    pub keys: [*const c_void; 5],
    /// Begins a group of edits that is undone in one step.
    pub edit_begin: Option<unsafe extern "C" fn(Handle, *const c_char) -> OfxStatus>,
    /// Ends the group of edits.
    pub edit_end: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
}

/// The suite's name.
pub const SUITE: &CStr = c"OfxParameterSuite";

/// Type: integer.
pub const TYPE_INTEGER: &CStr = c"OfxParamTypeInteger";
/// Type: floating-point number.
pub const TYPE_DOUBLE: &CStr = c"OfxParamTypeDouble";
/// Type: two floating-point numbers.
pub const TYPE_DOUBLE_2D: &CStr = c"OfxParamTypeDouble2D";
/// Type: boolean.
pub const TYPE_BOOLEAN: &CStr = c"OfxParamTypeBoolean";
/// Type: menu; the value is the index of the option.
pub const TYPE_CHOICE: &CStr = c"OfxParamTypeChoice";
/// Type: string.
pub const TYPE_STRING: &CStr = c"OfxParamTypeString";
/// Type: group of parameters.
pub const TYPE_GROUP: &CStr = c"OfxParamTypeGroup";
/// Type: page of parameters.
pub const TYPE_PAGE: &CStr = c"OfxParamTypePage";
/// Type: push button.
pub const TYPE_PUSH_BUTTON: &CStr = c"OfxParamTypePushButton";

/// Flag: the parameter can be animated.
pub const ANIMATES: &CStr = c"OfxParamPropAnimates";
/// Flag: a change makes rendered images out of date.
pub const EVALUATE_ON_CHANGE: &CStr = c"OfxParamPropEvaluateOnChange";
/// Flag: the parameter is hidden.
pub const SECRET: &CStr = c"OfxParamPropSecret";
/// Flag: the user can change the parameter.
pub const ENABLED: &CStr = c"OfxParamPropEnabled";
/// Tooltip.
pub const HINT: &CStr = c"OfxParamPropHint";
/// Name in scripts.
pub const SCRIPT_NAME: &CStr = c"OfxParamPropScriptName";
/// Name of the parameter's group.
pub const PARENT: &CStr = c"OfxParamPropParent";
/// Flag: a group is shown open.
pub const GROUP_OPEN: &CStr = c"OfxParamPropGroupOpen";
/// Names of the parameters on a page.
pub const PAGE_CHILD: &CStr = c"OfxParamPropPageChild";
/// Default value.
pub const DEFAULT: &CStr = c"OfxParamPropDefault";
/// Smallest value.
pub const MIN: &CStr = c"OfxParamPropMin";
/// Largest value.
pub const MAX: &CStr = c"OfxParamPropMax";
/// Smallest value of the slider.
pub const DISPLAY_MIN: &CStr = c"OfxParamPropDisplayMin";
/// Largest value of the slider.
pub const DISPLAY_MAX: &CStr = c"OfxParamPropDisplayMax";
/// Step of the slider.
pub const INCREMENT: &CStr = c"OfxParamPropIncrement";
/// Digits after the decimal point.
pub const DIGITS: &CStr = c"OfxParamPropDigits";
/// Meaning of a floating-point number.
pub const DOUBLE_TYPE: &CStr = c"OfxParamPropDoubleType";
/// Meaning: an absolute position.
pub const DOUBLE_TYPE_XY_ABSOLUTE: &CStr = c"OfxParamDoubleTypeXYAbsolute";
/// Meaning: a plain number.
pub const DOUBLE_TYPE_PLAIN: &CStr = c"OfxParamDoubleTypePlain";
/// Coordinate system of the default value.
pub const DEFAULT_COORDINATES: &CStr = c"OfxParamPropDefaultCoordinateSystem";
/// Coordinate system: canonical.
pub const COORDINATES_CANONICAL: &CStr = c"OfxParamCoordinatesCanonical";
/// Flag: the host should draw a handle for a position. The `k` is part of the property's name.
pub const HOST_OVERLAY_HANDLE: &CStr = c"kOfxParamPropUseHostOverlayHandle";
/// Flag: the host draws a handle for a position.
pub const HAS_HOST_OVERLAY_HANDLE: &CStr = c"OfxParamPropHasHostOverlayHandle";
/// Labels of the options of a menu.
pub const CHOICE_OPTION: &CStr = c"OfxParamPropChoiceOption";
/// Kind of string.
pub const STRING_MODE: &CStr = c"OfxParamPropStringMode";
/// Kind of string: a single line.
pub const STRING_SINGLE_LINE: &CStr = c"OfxParamStringIsSingleLine";
/// Kind of string: the path of a file.
pub const STRING_FILE_PATH: &CStr = c"OfxParamStringIsFilePath";
/// Flag: the file must exist.
pub const FILE_PATH_EXISTS: &CStr = c"OfxParamPropStringFilePathExists";
