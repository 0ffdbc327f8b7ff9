//! The draw suite of 1.5: overlays without OpenGL.

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
    /// Coverage.
    pub a: f32,
}

/// Draws on the context that a draw action is given.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxDrawSuiteV1 {
    /// A colour of the host's.
    pub get_colour: Option<unsafe extern "C" fn(Handle, c_int, *mut OfxRGBAColourF) -> OfxStatus>,
    /// What to draw with from now on.
    pub set_colour: Option<unsafe extern "C" fn(Handle, *const OfxRGBAColourF) -> OfxStatus>,
    /// Width of lines; 0 is one pixel.
    pub set_line_width: Option<unsafe extern "C" fn(Handle, f32) -> OfxStatus>,
    /// Dashes of lines.
    pub set_line_stipple: Option<unsafe extern "C" fn(Handle, c_int) -> OfxStatus>,
    /// Draws a primitive.
    pub draw: Option<unsafe extern "C" fn(Handle, c_int, *const OfxPointD, c_int) -> OfxStatus>,
    /// Draws a text.
    pub draw_text:
        Option<unsafe extern "C" fn(Handle, *const c_char, *const OfxPointD, c_int) -> OfxStatus>,
}

/// Name of the suite.
pub const SUITE: &CStr = c"OfxDrawSuite";
/// Colour of what can be taken hold of.
pub const COLOUR_ACTIVE: c_int = 1;
/// Colour of what cannot.
pub const COLOUR_DESELECTED: c_int = 3;
/// Primitive: pairs of points.
pub const LINES: c_int = 0;
/// Primitive: a closed line.
pub const LINE_LOOP: c_int = 2;
