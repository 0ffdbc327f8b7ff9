//! The draw suite: section "OfxDrawSuiteV1: Drawing Overlays", `ofxDrawSuite.h`. Since 1.5.

use std::ffi::{CStr, c_char, c_int};

use super::{Handle, OfxPointD, OfxStatus};

/// A colour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct OfxRGBAColourF {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Alpha.
    pub a: f32,
}

/// The draw suite. Handles are draw contexts, valid during a draw action.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxDrawSuiteV1 {
    /// Gets one of the host's standard colours.
    pub get_colour: Option<unsafe extern "C" fn(Handle, c_int, *mut OfxRGBAColourF) -> OfxStatus>,
    /// Sets the colour of later calls.
    pub set_colour: Option<unsafe extern "C" fn(Handle, *const OfxRGBAColourF) -> OfxStatus>,
    /// Sets the line width; 0 is one pixel.
    pub set_line_width: Option<unsafe extern "C" fn(Handle, f32) -> OfxStatus>,
    /// Sets the stipple pattern of lines.
    pub set_line_stipple: Option<unsafe extern "C" fn(Handle, c_int) -> OfxStatus>,
    /// Draws a primitive through a number of points.
    pub draw: Option<unsafe extern "C" fn(Handle, c_int, *const OfxPointD, c_int) -> OfxStatus>,
    /// Draws text at a point.
    pub draw_text:
        Option<unsafe extern "C" fn(Handle, *const c_char, *const OfxPointD, c_int) -> OfxStatus>,
}

/// The suite's name.
pub const SUITE: &CStr = c"OfxDrawSuite";
/// `kOfxStandardColourOverlayActive`: the colour of handles.
pub const COLOUR_ACTIVE: c_int = 1;
/// `kOfxStandardColourOverlayDeselected`: the colour of lines that cannot be dragged.
pub const COLOUR_DESELECTED: c_int = 3;
/// `kOfxDrawPrimitiveLines`: one line per pair of points.
pub const LINES: c_int = 0;
/// `kOfxDrawPrimitiveLineLoop`: a closed line.
pub const LINE_LOOP: c_int = 2;
