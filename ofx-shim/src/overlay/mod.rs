//! What is drawn over the viewer: how the lens draws points over the frame, where its axis is, and a handle to focus by.
//!
//! Only where the host has the draw suite: it draws without OpenGL, so the plugin links nothing of it.

mod axis;
mod draw;
pub(crate) mod grid;
mod pen;
mod place;

use std::ffi::{CStr, c_char, c_void};

use crate::actions::Call;
use crate::host::{self, Effect, Host, Props, Result};
use crate::sys::effect::OVERLAY_V2;
use crate::sys::plugin::{STATUS_FAILED, STATUS_OK, STATUS_REPLY_DEFAULT};
use crate::sys::property::EFFECT_INSTANCE;
use crate::sys::{Handle, OfxEntry, OfxStatus, actions, interact};

/// Says in the descriptor `props` that there is an overlay, where `host` can draw one.
pub(crate) fn offer(host: &Host, props: &Props) {
    if host.suites.draw.is_some() && host.suites.interact.is_some() {
        let entry: OfxEntry = overlay_entry;
        props.set_pointer(OVERLAY_V2, entry as *mut c_void);
    }
}

unsafe extern "C" fn overlay_entry(
    action: *const c_char,
    handle: *const c_void,
    inputs: Handle,
    outputs: Handle,
) -> OfxStatus {
    let done = host::caught(|| {
        if action.is_null() {
            return STATUS_FAILED;
        }
        // SAFETY: hosts give the name of an action, a text with a zero at its end.
        let action = unsafe { CStr::from_ptr(action) };
        perform(action, handle.cast_mut(), inputs, outputs)
    });
    done.unwrap_or(STATUS_FAILED)
}

fn perform(action: &CStr, handle: Handle, inputs: Handle, outputs: Handle) -> OfxStatus {
    let Some(host) = host::current() else {
        return STATUS_FAILED;
    };
    let work: fn(&Call, Handle) -> Result<bool> = match action {
        name if name == interact::ACTION_DRAW => draw::draw,
        name if name == interact::ACTION_PEN_DOWN => pen::down,
        name if name == interact::ACTION_PEN_MOTION => pen::motion,
        name if name == interact::ACTION_PEN_UP => pen::up,
        name if name == actions::DESCRIBE || name == actions::CREATE_INSTANCE => return STATUS_OK,
        name if name == actions::DESTROY_INSTANCE => {
            pen::forget(handle);
            return STATUS_OK;
        }
        _ => return STATUS_REPLY_DEFAULT,
    };
    let props = |handle| Props::of(&host.suites.property, handle);
    let Some(effect) = effect_of(&host, handle, &props(inputs)) else {
        return STATUS_REPLY_DEFAULT;
    };
    let call = Call {
        host: &host,
        effect: Effect {
            host: &host,
            handle: effect,
        },
        arguments: props(inputs),
        answers: props(outputs),
    };
    // What an overlay cannot draw is told where it is rendered.
    match work(&call, handle) {
        Ok(true) => STATUS_OK,
        Ok(false) | Err(_) => STATUS_REPLY_DEFAULT,
    }
}

/// The instance that an overlay is of.
fn effect_of(host: &Host, overlay: Handle, inputs: &Props) -> Option<Handle> {
    let own = host.suites.interact.and_then(|suite| {
        let mut props = std::ptr::null_mut();
        let get = suite.property_set?;
        // SAFETY: the host vouches for its function and its handle.
        let status = unsafe { get(overlay, &raw mut props) };
        let props = Props::of(&host.suites.property, props);
        (status == STATUS_OK).then(|| props.pointer(EFFECT_INSTANCE))?
    });
    own.or_else(|| inputs.pointer(EFFECT_INSTANCE))
}

/// Asks for the overlay to be drawn again.
fn redraw(host: &Host, overlay: Handle) {
    let redraw = host.suites.interact.and_then(|suite| suite.redraw);
    if let Some(redraw) = redraw {
        // SAFETY: as above.
        unsafe { redraw(overlay) };
    }
}
