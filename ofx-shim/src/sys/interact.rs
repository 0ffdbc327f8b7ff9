//! The interact suite, and names of actions and properties of overlays.

use std::ffi::CStr;

use super::{Handle, OfxStatus};

/// What an overlay can ask of its host.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct OfxInteractSuiteV1 {
    /// Not used.
    pub swap_buffers: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
    /// Draw again.
    pub redraw: Option<unsafe extern "C" fn(Handle) -> OfxStatus>,
    /// Properties of an overlay.
    pub property_set: Option<unsafe extern "C" fn(Handle, *mut Handle) -> OfxStatus>,
}

/// Name of the suite.
pub const SUITE: &CStr = c"OfxInteractSuite";

/// Draw it.
pub const ACTION_DRAW: &CStr = c"OfxInteractActionDraw";
/// The pen moved.
pub const ACTION_PEN_MOTION: &CStr = c"OfxInteractActionPenMotion";
/// The pen was set down.
pub const ACTION_PEN_DOWN: &CStr = c"OfxInteractActionPenDown";
/// The pen was lifted.
pub const ACTION_PEN_UP: &CStr = c"OfxInteractActionPenUp";

/// What the draw suite draws on.
pub const DRAW_CONTEXT: &CStr = c"OfxInteractPropDrawContext";
/// Size of a screen pixel, canonical.
pub const PIXEL_SCALE: &CStr = c"OfxInteractPropPixelScale";
/// Where the pen is, canonical.
pub const PEN_POSITION: &CStr = c"OfxInteractPropPenPosition";
/// Parameters at whose change it is drawn again.
pub const SLAVE_TO_PARAM: &CStr = c"OfxInteractPropSlaveToParam";
