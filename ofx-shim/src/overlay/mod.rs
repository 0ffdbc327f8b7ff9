//! The overlay in the viewer: PSF outlines over the frame, the optical axis, and a handle to set the focus.
//!
//! It is offered only in hosts with the draw suite, which works without OpenGL.

mod drawing;
mod focus_handle;
mod lens_placement;
mod psf_ellipses;

use std::ffi::{CStr, c_char, c_void};

use crate::host::{self, Call, Host, PropertySet, Result};
use crate::sys::effect::OVERLAY_V2;
use crate::sys::plugin::{STATUS_FAILED, STATUS_OK, STATUS_REPLY_DEFAULT};
use crate::sys::property::EFFECT_INSTANCE;
use crate::sys::{Handle, OfxEntry, OfxStatus, actions, interact};

pub(crate) use psf_ellipses::forget;

/// Returns whether `host` can draw the overlay.
pub(crate) fn is_offered(host: &Host) -> bool {
    host.suites.draw.is_some() && host.suites.interact.is_some()
}

/// Declares the overlay in the properties of a descriptor, if `host` can draw it.
pub(crate) fn declare(host: &Host, properties: &PropertySet) {
    if is_offered(host) {
        let entry: OfxEntry = overlay_entry;
        properties.set_pointer(OVERLAY_V2, entry as *mut c_void);
    }
}

unsafe extern "C" fn overlay_entry(
    action: *const c_char,
    overlay: *const c_void,
    arguments: Handle,
    results: Handle,
) -> OfxStatus {
    let status = host::catch_panic(|| {
        if action.is_null() {
            return STATUS_FAILED;
        }
        // SAFETY: the host passes the name of an action as a C string.
        let action = unsafe { CStr::from_ptr(action) };
        perform(action, overlay.cast_mut(), arguments, results)
    });
    status.unwrap_or(STATUS_FAILED)
}

fn perform(action: &CStr, overlay: Handle, arguments: Handle, results: Handle) -> OfxStatus {
    let Some(host) = host::current() else {
        return STATUS_FAILED;
    };
    // Returns whether the action was handled.
    let handler: fn(&Call, Handle) -> Result<bool> = match action {
        name if name == interact::ACTION_DRAW => drawing::draw,
        name if name == interact::ACTION_PEN_DOWN => focus_handle::pen_down,
        name if name == interact::ACTION_PEN_MOTION => focus_handle::pen_motion,
        name if name == interact::ACTION_PEN_UP => focus_handle::pen_up,
        name if name == actions::DESCRIBE || name == actions::CREATE_INSTANCE => return STATUS_OK,
        name if name == actions::DESTROY_INSTANCE => {
            focus_handle::forget(overlay);
            return STATUS_OK;
        }
        _ => return STATUS_REPLY_DEFAULT,
    };
    let Some(effect) = effect_of(&host, overlay, &host.property_set(arguments)) else {
        return STATUS_REPLY_DEFAULT;
    };
    let call = Call::new(&host, effect, arguments, results);
    // Errors are not shown here: the render of the same settings fails with the same message.
    if handler(&call, overlay).unwrap_or(false) {
        STATUS_OK
    } else {
        STATUS_REPLY_DEFAULT
    }
}

/// Returns the effect instance of an overlay.
fn effect_of(host: &Host, overlay: Handle, arguments: &PropertySet) -> Option<Handle> {
    let effect = host.suites.interact.and_then(|suite| {
        let mut set = std::ptr::null_mut();
        let get = suite.property_set?;
        // SAFETY: a function and a handle of the host, and memory for a handle.
        let status = unsafe { get(overlay, &raw mut set) };
        let properties = host.property_set(set);
        (status == STATUS_OK).then(|| properties.pointer(EFFECT_INSTANCE))?
    });
    effect.or_else(|| arguments.pointer(EFFECT_INSTANCE))
}

/// Requests a redraw of the overlay.
fn redraw(host: &Host, overlay: Handle) {
    let redraw = host.suites.interact.and_then(|suite| suite.redraw);
    if let Some(redraw) = redraw {
        // SAFETY: a function and a handle of the host.
        unsafe { redraw(overlay) };
    }
}
