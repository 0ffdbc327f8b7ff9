//! The handle that sets the focus: drag and drop.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::redraw;
use crate::host::{Call, ParameterValue, Result};
use crate::knobs::{Knobs, focus};
use crate::rendering::focus_at;
use crate::sys::Handle;
use crate::sys::interact::{PEN_POSITION, PIXEL_SCALE};
use crate::sys::param::HAS_HOST_OVERLAY_HANDLE;

/// Distance from which the pen picks up the handle, in screen pixels.
const PICK_RADIUS: f64 = 10.0;

/// Positions of the handles being dragged, in canonical coordinates, by the address of the overlay.
static DRAGGED: Mutex<BTreeMap<usize, (f64, f64)>> = Mutex::new(BTreeMap::new());

fn dragged() -> MutexGuard<'static, BTreeMap<usize, (f64, f64)>> {
    // The map is consistent even if a thread panicked while it held the lock.
    DRAGGED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Forgets the drag of an overlay that is destroyed.
pub(super) fn forget(overlay: Handle) {
    dragged().remove(&overlay.addr());
}

/// Returns the size of a screen pixel in canonical coordinates, 1 if the host does not report it.
pub(super) fn pixel_scale(call: &Call) -> (f64, f64) {
    let [x, y] = call.arguments.doubles(PIXEL_SCALE).unwrap_or([1.0; 2]);
    let positive = |v: f64| if v.is_finite() && v > 0.0 { v } else { 1.0 };
    (positive(x), positive(y))
}

/// Returns whether the host draws a handle itself.
pub(super) fn is_drawn_by_host(call: &Call) -> bool {
    let properties = call.effect.parameters().properties_of(focus::POINT.name);
    properties.is_some_and(|set| set.int(HAS_HOST_OVERLAY_HANDLE, 0).unwrap_or(0) != 0)
}

/// Returns the position of the handle in canonical coordinates.
pub(super) fn position(knobs: &Knobs, overlay: Handle) -> (f64, f64) {
    let position = dragged().get(&overlay.addr()).copied();
    position.unwrap_or_else(|| knobs.pair(&focus::POINT))
}

/// Starts a drag if the pen is on the handle.
pub(super) fn pen_down(call: &Call, overlay: Handle) -> Result<bool> {
    if is_drawn_by_host(call) {
        return Ok(false);
    }
    let Some([x, y]) = call.arguments.doubles::<2>(PEN_POSITION) else {
        return Ok(false);
    };
    let time = call.time();
    let handle = Knobs::at(&call.effect, time).pair(&focus::POINT);
    let pixel = pixel_scale(call);
    let distance = ((x - handle.0) / pixel.0).hypot((y - handle.1) / pixel.1);
    let is_picked = distance <= PICK_RADIUS;
    if is_picked {
        dragged().insert(overlay.addr(), handle);
    }
    Ok(is_picked)
}

/// Moves the handle to the pen during a drag.
pub(super) fn pen_motion(call: &Call, overlay: Handle) -> Result<bool> {
    let Some([x, y]) = call.arguments.doubles::<2>(PEN_POSITION) else {
        return Ok(false);
    };
    let mut dragged = dragged();
    let Some(position) = dragged.get_mut(&overlay.addr()) else {
        return Ok(false);
    };
    *position = (x, y);
    // The host may call back, so the lock must be free.
    drop(dragged);
    redraw(call.host, overlay);
    Ok(true)
}

/// Ends a drag: sets the focus to the depth under the handle.
pub(super) fn pen_up(call: &Call, overlay: Handle) -> Result<bool> {
    let Some(mut position) = dragged().remove(&overlay.addr()) else {
        return Ok(false);
    };
    if let Some([x, y]) = call.arguments.doubles::<2>(PEN_POSITION) {
        position = (x, y);
    }
    let point = ParameterValue::Double2D(position.0, position.1);
    let mut changes = vec![(focus::POINT.name, point)];
    let focus = focus_at(call, position);
    changes.extend(focus.iter().flatten().cloned());
    call.effect.parameters().set(c"Focal point", &changes);
    focus?;
    redraw(call.host, overlay);
    Ok(true)
}
