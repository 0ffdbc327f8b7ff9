//! InstanceChanged: a parameter was changed by the user, by the plugin, or by a project that was loaded.

use std::ffi::{CStr, CString};

use seidel_optics::library;

use super::{Answer, check_lens, enabled, guess_depth, persistent_message, show_lens_data};
use crate::clips::DEPTH;
use crate::host::{Call, Change, ParameterSet, ParameterValue, Result};
use crate::knobs::{Knob, Knobs, focus, lens, look, remove};
use crate::lens::built_in;
use crate::rendering::focus_at;
use crate::sys::param::CHOICE_OPTION;
use crate::sys::property::{CHANGE_REASON, CHANGE_TIME, CHANGE_USER_EDITED, NAME, TYPE, TYPE_CLIP};

/// Carries out what the change asks for.
pub(super) fn changed(call: &Call) -> Result<Answer> {
    if call.arguments.equals(CHANGE_REASON, CHANGE_TIME) {
        return Ok(Answer::Default);
    }
    // The change may have removed the cause; Nuke does not render until the message is cleared.
    persistent_message::clear(call.host, call.effect.handle);
    let time = call.time();
    if call.arguments.equals(NAME, lens::RELOAD.name) {
        let knobs = Knobs::at(&call.effect, time);
        // Hosts cache images by parameters, so that one must change for their images to be outdated.
        let reloads = knobs.hidden(&lens::RELOADS).wrapping_add(1).max(0);
        let change = (lens::RELOADS.name, ParameterValue::Int(reloads));
        (call.effect.parameters()).set(c"Reload lens files", &[change]);
    }
    let by_user = call.arguments.equals(CHANGE_REASON, CHANGE_USER_EDITED);
    if by_user && call.arguments.equals(NAME, focus::POINT.name) {
        let point = Knobs::at(&call.effect, time).pair(&focus::POINT);
        call.effect.parameters().follow(&focus_at(call, point)?);
    }
    if by_user && call.arguments.equals(NAME, lens::FOLDER.name) {
        choose_own_lens(call, time);
    }
    if by_user && call.arguments.equals(NAME, look::PRESET.name) {
        let parameters = call.effect.parameters();
        let index = parameters.int(look::PRESET.name, time).unwrap_or(0);
        set_by_menu(
            &parameters,
            &look::PRESET,
            c"Set look",
            &look::preset_changes(index),
        );
    }
    if by_user && call.arguments.equals(NAME, remove::CHECK_LENS.name) {
        check_lens::check(call);
    }
    if by_user && call.arguments.equals(NAME, lens::SHOW_DATA.name) {
        show_lens_data::show(call);
    }
    let is_clip = call.arguments.equals(TYPE, TYPE_CLIP);
    if by_user && is_clip && call.arguments.equals(NAME, DEPTH) {
        guess_depth::guess(call);
    } else if by_user {
        guess_depth::guess_if_due(call);
    }
    enabled::update(&call.effect, time);
    Ok(Answer::Done)
}

/// Puts the profile chosen in the menu of the folder into Lens and Lens File, and sets the menu back.
fn choose_own_lens(call: &Call, time: f64) {
    let parameters = call.effect.parameters();
    let index = parameters.int(lens::FOLDER.name, time).unwrap_or(0);
    let properties = parameters.properties_of(lens::FOLDER.name);
    // The label is that of the menu that the user saw, whatever the folder holds now.
    let label = properties.and_then(|p| p.string(CHOICE_OPTION, index));
    let reference = label.map(|label| format!("{}{label}", library::PREFIX));
    let Some(reference) = reference.and_then(|text| CString::new(text).ok()) else {
        return;
    };
    if index > 0 {
        let changes = [
            (lens::LENS.name, ParameterValue::Int(built_in::FILE)),
            (lens::PROFILE.name, ParameterValue::Text(reference)),
        ];
        set_by_menu(&parameters, &lens::FOLDER, c"Choose lens", &changes);
    }
}

/// Makes the changes that the user chose in a `menu`, in one undo step, and sets the menu back outside it: undoing that would choose
/// the entry again.
fn set_by_menu(parameters: &ParameterSet, menu: &Knob, step: &CStr, changes: &[Change]) {
    if !changes.is_empty() {
        parameters.follow(&[(menu.name, ParameterValue::Int(0))]);
        parameters.set(step, changes);
    }
}
