//! The handle to focus by: taken hold of, moved, let go.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::redraw;
use crate::actions::{Call, focus_there};
use crate::host::{Result, Value};
use crate::knobs::{Knobs, focus};
use crate::sys::Handle;
use crate::sys::interact::{PEN_POSITION, PIXEL_SCALE};
use crate::sys::property::TIME;

/// How near the pen must be, screen pixels.
const REACH: f64 = 10.0;

/// Handles that are held, by overlay, and where they are.
static HELD: Mutex<BTreeMap<usize, (f64, f64)>> = Mutex::new(BTreeMap::new());

fn held() -> MutexGuard<'static, BTreeMap<usize, (f64, f64)>> {
    // The map is whole wherever a thread may have died.
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Nothing is held of an overlay that is gone.
pub(super) fn forget(overlay: Handle) {
    held().remove(&overlay.addr());
}

/// Size of a screen pixel, canonical.
pub(super) fn pixel_scale(said: Option<[f64; 2]>) -> (f64, f64) {
    let [x, y] = said.unwrap_or([1.0; 2]);
    let sound = |v: f64| if v.is_finite() && v > 0.0 { v } else { 1.0 };
    (sound(x), sound(y))
}

/// Whether the host draws a handle itself.
pub(super) fn is_drawn_by_host(call: &Call) -> bool {
    let props = call.effect.params().props_of(focus::POINT.name);
    props.is_some_and(|props| props.int(HAS_HANDLE, 0).unwrap_or(0) != 0)
}

const HAS_HANDLE: &std::ffi::CStr = c"OfxParamPropHasHostOverlayHandle";

/// Where the handle is, canonical.
pub(super) fn position(knobs: &Knobs, overlay: Handle) -> (f64, f64) {
    let moved = held().get(&overlay.addr()).copied();
    moved.unwrap_or_else(|| knobs.pair(&focus::POINT))
}

/// Takes hold of the handle where the pen is on it.
pub(super) fn down(call: &Call, overlay: Handle) -> Result<bool> {
    if is_drawn_by_host(call) {
        return Ok(false);
    }
    let Some([x, y]) = call.arguments.doubles::<2>(PEN_POSITION) else {
        return Ok(false);
    };
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    let at = Knobs::of(&call.effect, time).pair(&focus::POINT);
    let pixel = pixel_scale(call.arguments.doubles(PIXEL_SCALE));
    let near = ((x - at.0) / pixel.0).hypot((y - at.1) / pixel.1) <= REACH;
    if near {
        held().insert(overlay.addr(), at);
    }
    Ok(near)
}

/// Moves it with the pen.
pub(super) fn motion(call: &Call, overlay: Handle) -> Result<bool> {
    let Some([x, y]) = call.arguments.doubles::<2>(PEN_POSITION) else {
        return Ok(false);
    };
    let mut held = held();
    let Some(at) = held.get_mut(&overlay.addr()) else {
        return Ok(false);
    };
    *at = (x, y);
    drop(held);
    redraw(call.host, overlay);
    Ok(true)
}

/// Lets it go: what is there is in focus.
pub(super) fn up(call: &Call, overlay: Handle) -> Result<bool> {
    let Some(mut at) = held().remove(&overlay.addr()) else {
        return Ok(false);
    };
    if let Some([x, y]) = call.arguments.doubles::<2>(PEN_POSITION) {
        at = (x, y);
    }
    let change = (focus::POINT.name, Value::Pair(at.0, at.1));
    call.effect.params().set(c"Focal point", &[change]);
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    focus_there(call, time)?;
    redraw(call.host, overlay);
    Ok(true)
}
