//! The interact suite, and actions and properties of overlays: sections "Interacts" and "Actions Passed to an Interact",
//! `ofxInteract.h` and `ofxDrawSuite.h`.

use std::ffi::CStr;

use super::{Handle, OfxStatus};

/// The interact suite.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxInteractSuiteV1 {
    /// Swaps the OpenGL buffers: not used.
    pub swap_buffers: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
    /// Requests a redraw.
    pub redraw: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
    /// Gets the property set of an interact.
    pub property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
}

/// The suite's name.
pub const SUITE: &CStr = c"OfxInteractSuite";

/// Draws the overlay.
pub const ACTION_DRAW: &CStr = c"OfxInteractActionDraw";
/// The pen moved, up or down.
pub const ACTION_PEN_MOTION: &CStr = c"OfxInteractActionPenMotion";
/// The pen, or a mouse button, was pressed.
pub const ACTION_PEN_DOWN: &CStr = c"OfxInteractActionPenDown";
/// The pen, or a mouse button, was released.
pub const ACTION_PEN_UP: &CStr = c"OfxInteractActionPenUp";

/// Argument: the context of the draw suite.
pub const DRAW_CONTEXT: &CStr = c"OfxInteractPropDrawContext";
/// Argument: width and height of a screen pixel, in canonical coordinates.
pub const PIXEL_SCALE: &CStr = c"OfxInteractPropPixelScale";
/// Argument: position of the pen, in canonical coordinates.
pub const PEN_POSITION: &CStr = c"OfxInteractPropPenPosition";
