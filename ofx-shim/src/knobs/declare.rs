//! Declaration of the knobs to the host.

use std::ffi::CStr;

use super::{ALL, Group, Kind, Knob, PresetMenu};
use crate::host::{Effect, Host, ParameterSet, PropertySet};
use crate::sys::param as p;
use crate::sys::property::{LABEL, LONG_LABEL, SHORT_LABEL};

/// Knobs that are off by default in Resolve, which reports every clip as connected.
const OFF_IN_RESOLVE: [&Knob; 3] = [
    &super::depth::USE_DEPTH,
    &super::render::USE_HOLDOUT,
    &super::output::USE_MASK,
];

/// The page of all knobs, for hosts with pages.
const PAGE: &CStr = c"Controls";

/// Largest coordinate of positions, in pixels. Infinity is no valid range in Nuke.
const MAX_POSITION: f64 = 1e6;
/// Largest coordinate of positions on sliders, in pixels.
const MAX_SLIDER_POSITION: f64 = 4000.0;

/// Declares all knobs to a descriptor.
pub(crate) fn declare(effect: &Effect) {
    let parameters = effect.parameters();
    for group in ALL {
        let has_group = declare_group(&parameters, group);
        for knob in group.knobs() {
            let Some(properties) = parameters.define(type_of(knob), knob.name) else {
                // The host does not know the type: the knob stays at its default.
                continue;
            };
            set_labels(&properties, knob.label);
            properties.set_string(p::HINT, 0, knob.hint);
            properties.set_string(p::SCRIPT_NAME, 0, knob.name);
            if has_group {
                properties.set_string(p::PARENT, 0, group.name);
            }
            set_properties(&properties, knob, effect.host.is_resolve());
            if is_idle(knob, effect.host) {
                properties.set_int(p::SECRET, 0, 1);
            }
        }
    }
    if let Some(page) = parameters.define(p::TYPE_PAGE, PAGE) {
        set_labels(&page, PAGE);
        // Natron puts a group that no page lists at the end.
        let children = ALL.iter().flat_map(|group| {
            let knobs = group.knobs().into_iter().map(|knob| knob.name);
            std::iter::once(group.name).chain(knobs)
        });
        for (index, name) in children.enumerate() {
            page.set_string(p::PAGE_CHILD, index as i32, name);
        }
    }
}

/// Returns whether a knob can never have an effect in this host.
fn is_idle(knob: &Knob, host: &Host) -> bool {
    match knob.kind {
        Kind::Presets(menu) => menu.entries().is_empty(),
        _ => knob.name == super::output::SHOW_LENS.name && !crate::overlay::is_offered(host),
    }
}

/// Declares a group; returns whether the host supports groups.
fn declare_group(parameters: &ParameterSet, group: &Group) -> bool {
    let Some(properties) = parameters.define(p::TYPE_GROUP, group.name) else {
        return false;
    };
    set_labels(&properties, group.label);
    properties.set_int(p::GROUP_OPEN, 0, i32::from(group.open));
    true
}

fn set_labels(properties: &PropertySet, label: &CStr) {
    for name in [LABEL, SHORT_LABEL, LONG_LABEL] {
        properties.set_string(name, 0, label);
    }
}

fn type_of(knob: &Knob) -> &'static CStr {
    match knob.kind {
        Kind::Number { .. } => p::TYPE_DOUBLE,
        Kind::Pair { .. } => p::TYPE_DOUBLE_2D,
        Kind::Switch(_) => p::TYPE_BOOLEAN,
        Kind::Choice { .. } | Kind::Presets(_) => p::TYPE_CHOICE,
        Kind::File | Kind::Text => p::TYPE_STRING,
        Kind::Button => p::TYPE_PUSH_BUTTON,
        Kind::Hidden => p::TYPE_INTEGER,
    }
}

/// Returns the step of a knob: a power of ten of about a thousandth of its slider, and at least its last digit.
fn step(slider: (f64, f64), digits: i32) -> f64 {
    let thousandth = (slider.1 - slider.0) / 1000.0;
    let power = thousandth.log10().round() as i32;
    10.0_f64.powi(power.max(-digits))
}

/// Sets the properties that depend on the type of the knob.
fn set_properties(properties: &PropertySet, knob: &Knob, in_resolve: bool) {
    match knob.kind {
        Kind::Number {
            default,
            range,
            slider,
            digits,
        } => {
            properties.set_string(p::DOUBLE_TYPE, 0, p::DOUBLE_TYPE_PLAIN);
            properties.set_double(p::DEFAULT, 0, default);
            // Resolve clamps values to -1..1 unless all four are set.
            properties.set_double(p::MIN, 0, range.0);
            properties.set_double(p::MAX, 0, range.1);
            properties.set_double(p::DISPLAY_MIN, 0, slider.0);
            properties.set_double(p::DISPLAY_MAX, 0, slider.1);
            properties.set_int(p::DIGITS, 0, digits);
            properties.set_double(p::INCREMENT, 0, step(slider, digits));
        }
        Kind::Pair { default, position } => {
            if position {
                properties.set_string(p::DOUBLE_TYPE, 0, p::DOUBLE_TYPE_XY_ABSOLUTE);
                // Nuke takes defaults as normalised coordinates otherwise.
                properties.set_string(p::DEFAULT_COORDINATES, 0, p::COORDINATES_CANONICAL);
                properties.set_int(p::HOST_OVERLAY_HANDLE, 0, 1);
                properties.set_int(p::EVALUATE_ON_CHANGE, 0, 0);
                properties.set_int(p::ANIMATES, 0, 0);
            } else {
                properties.set_string(p::DOUBLE_TYPE, 0, p::DOUBLE_TYPE_PLAIN);
            }
            properties.set_doubles(p::DEFAULT, &[default.0, default.1]);
            for (name, value) in [
                (p::MIN, -MAX_POSITION),
                (p::MAX, MAX_POSITION),
                (p::DISPLAY_MIN, -MAX_SLIDER_POSITION),
                (p::DISPLAY_MAX, MAX_SLIDER_POSITION),
            ] {
                properties.set_doubles(name, &[value, value]);
            }
            properties.set_int(p::DIGITS, 0, 2);
        }
        Kind::Switch(on) => {
            let is_off = in_resolve && OFF_IN_RESOLVE.iter().any(|other| other.name == knob.name);
            properties.set_int(p::DEFAULT, 0, i32::from(on && !is_off));
            if knob.name == super::output::SHOW_LENS.name {
                // The overlay is no part of the rendered image.
                properties.set_int(p::EVALUATE_ON_CHANGE, 0, 0);
            }
            properties.set_int(p::ANIMATES, 0, 0);
        }
        Kind::Choice { default, options } => {
            for (index, option) in options.iter().enumerate() {
                properties.set_string(p::CHOICE_OPTION, index as i32, option);
            }
            properties.set_int(p::DEFAULT, 0, default);
            properties.set_int(p::ANIMATES, 0, 0);
        }
        Kind::Presets(menu) => {
            properties.set_string(p::CHOICE_OPTION, 0, PresetMenu::NOTHING);
            for (index, name) in menu.entries().iter().enumerate() {
                properties.set_string(p::CHOICE_OPTION, index as i32 + 1, name);
            }
            properties.set_int(p::DEFAULT, 0, 0);
            properties.set_int(p::ANIMATES, 0, 0);
            // It changes other knobs, which projects keep.
            properties.set_int(p::EVALUATE_ON_CHANGE, 0, 0);
        }
        Kind::File => {
            properties.set_string(p::STRING_MODE, 0, p::STRING_FILE_PATH);
            properties.set_int(p::FILE_PATH_EXISTS, 0, 1);
            properties.set_string(p::DEFAULT, 0, c"");
            properties.set_int(p::ANIMATES, 0, 0);
        }
        Kind::Text => {
            properties.set_string(p::STRING_MODE, 0, p::STRING_SINGLE_LINE);
            properties.set_string(p::DEFAULT, 0, c"");
            properties.set_int(p::ANIMATES, 0, 0);
        }
        Kind::Button => {}
        Kind::Hidden => {
            properties.set_int(p::DEFAULT, 0, 0);
            for (name, value) in [
                (p::MIN, 0),
                (p::MAX, i32::MAX),
                (p::DISPLAY_MIN, 0),
                (p::DISPLAY_MAX, i32::MAX),
            ] {
                properties.set_int(name, 0, value);
            }
            // Set on the descriptor, because some hosts do not let instances change it.
            properties.set_int(p::SECRET, 0, 1);
            properties.set_int(p::ANIMATES, 0, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_fit_the_range_and_the_digits() {
        let close = |step: f64, want: f64| (step / want - 1.0).abs() < 1e-12;
        // Noise, Amount, Along Ray Focal, and Maximum.
        assert!(close(step((0.0, 0.1), 5), 1e-4));
        assert!(close(step((0.0, 2.0), 3), 1e-3));
        assert!(close(step((0.0, 10_000.0), 1), 10.0));
        assert!(close(step((0.0, 256.0), 1), 0.1));
    }
}
