//! Something was changed: by the user, by the plugin, or by a project that was loaded.

use super::{Answer, Call, check_lens, enabled, focal_point, untell};
use crate::host::{ParameterValue, Result};
use crate::knobs::{Knobs, focus, lens, remove};
use crate::sys::property::{CHANGE_REASON, CHANGE_TIME, CHANGE_USER_EDITED, NAME, TIME};

/// Acts on it.
pub(super) fn changed(call: &Call) -> Result<Answer> {
    if call.arguments.equals(CHANGE_REASON, CHANGE_TIME) {
        return Ok(Answer::Default);
    }
    // What was wrong may be mended; Nuke does not render before it is taken back.
    untell(call.host, call.effect.handle);
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    if call.arguments.equals(NAME, lens::RELOAD.name) {
        let knobs = Knobs::at(&call.effect, time);
        // Hosts keep pictures by knobs: one of them must be another for what they kept to be old.
        let reloads = knobs.hidden(&lens::RELOADS).wrapping_add(1).max(0);
        let change = (lens::RELOADS.name, ParameterValue::Int(reloads));
        (call.effect.parameters()).set(c"Reload lens files", &[change]);
    }
    let by_user = call.arguments.equals(CHANGE_REASON, CHANGE_USER_EDITED);
    if by_user && call.arguments.equals(NAME, focus::POINT.name) {
        focal_point::focus(call, time)?;
    }
    if by_user && call.arguments.equals(NAME, remove::CHECK_LENS.name) {
        check_lens::check(call, time);
    }
    enabled::show(&call.effect, time);
    Ok(Answer::Done)
}
