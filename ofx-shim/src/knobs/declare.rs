//! Declaring knobs to the host.

use std::ffi::CStr;

use super::{ALL, Group, Kind, Knob};
use crate::host::{Effect, Params, Props};
use crate::sys::param as p;
use crate::sys::property::{LABEL, LONG_LABEL, SHORT_LABEL};

/// Knobs that are off where the host says of every clip that it is connected.
const OFF_IN_RESOLVE: [&Knob; 3] = [
    &super::depth::USE_DEPTH,
    &super::render::USE_HOLDOUT,
    &super::output::USE_MASK,
];

/// The page on which all knobs are, for hosts that have pages.
const PAGE: &CStr = c"Controls";

/// Declares all knobs to a descriptor.
pub(crate) fn declare(effect: &Effect) {
    let params = effect.params();
    for group in ALL {
        let parent = declare_group(&params, group);
        for knob in group.knobs {
            let Some(props) = params.define(kind_of(knob), knob.name) else {
                // The host has no such type: the default holds.
                continue;
            };
            named(&props, knob.label);
            props.set_string(p::HINT, 0, knob.hint);
            props.set_string(p::SCRIPT_NAME, 0, knob.name);
            if parent {
                props.set_string(p::PARENT, 0, group.name);
            }
            fill(&props, knob, effect.host.is_resolve());
        }
    }
    if let Some(page) = params.define(p::TYPE_PAGE, PAGE) {
        named(&page, PAGE);
        let shown = ALL.iter().flat_map(|group| group.knobs);
        for (index, knob) in shown.enumerate() {
            page.set_string(p::PAGE_CHILD, index as i32, knob.name);
        }
    }
}

fn declare_group(params: &Params, group: &Group) -> bool {
    let Some(props) = params.define(p::TYPE_GROUP, group.name) else {
        return false;
    };
    named(&props, group.label);
    props.set_int(p::GROUP_OPEN, 0, i32::from(group.open));
    true
}

fn named(props: &Props, label: &CStr) {
    for name in [LABEL, SHORT_LABEL, LONG_LABEL] {
        props.set_string(name, 0, label);
    }
}

fn kind_of(knob: &Knob) -> &'static CStr {
    match knob.kind {
        Kind::Number { .. } => p::TYPE_DOUBLE,
        Kind::Pair { .. } => p::TYPE_DOUBLE_2D,
        Kind::Switch(_) => p::TYPE_BOOLEAN,
        Kind::Choice { .. } => p::TYPE_CHOICE,
        Kind::File | Kind::Text => p::TYPE_STRING,
        Kind::Button => p::TYPE_PUSH_BUTTON,
        Kind::Hidden => p::TYPE_INTEGER,
    }
}

/// Largest distance of positions, pixels. Infinities are no ranges (Nuke).
const FARTHEST: f64 = 1e6;

fn fill(props: &Props, knob: &Knob, resolve: bool) {
    match knob.kind {
        Kind::Number {
            default,
            range,
            slider,
            digits,
        } => {
            props.set_string(p::DOUBLE_TYPE, 0, p::DOUBLE_TYPE_PLAIN);
            props.set_double(p::DEFAULT, 0, default);
            // All four: Resolve clamps to -1..1 otherwise.
            props.set_double(p::MIN, 0, range.0);
            props.set_double(p::MAX, 0, range.1);
            props.set_double(p::DISPLAY_MIN, 0, slider.0);
            props.set_double(p::DISPLAY_MAX, 0, slider.1);
            props.set_int(p::DIGITS, 0, digits);
            props.set_double(p::INCREMENT, 0, 0.1_f64.powi(digits.min(3)));
        }
        Kind::Pair { default, position } => {
            if position {
                props.set_string(p::DOUBLE_TYPE, 0, p::DOUBLE_TYPE_XY_ABSOLUTE);
                // Nuke's default is normalised.
                props.set_string(p::DEFAULT_COORDINATES, 0, p::COORDINATES_CANONICAL);
                props.set_int(p::HOST_OVERLAY_HANDLE, 0, 1);
                props.set_int(p::EVALUATE_ON_CHANGE, 0, 0);
                props.set_int(p::ANIMATES, 0, 0);
            } else {
                props.set_string(p::DOUBLE_TYPE, 0, p::DOUBLE_TYPE_PLAIN);
            }
            props.set_doubles(p::DEFAULT, &[default.0, default.1]);
            for (name, value) in [
                (p::MIN, -FARTHEST),
                (p::MAX, FARTHEST),
                (p::DISPLAY_MIN, -10_000.0),
                (p::DISPLAY_MAX, 10_000.0),
            ] {
                props.set_doubles(name, &[value, value]);
            }
            props.set_int(p::DIGITS, 0, 2);
        }
        Kind::Switch(on) => {
            let off = resolve && OFF_IN_RESOLVE.iter().any(|other| other.name == knob.name);
            props.set_int(p::DEFAULT, 0, i32::from(on && !off));
            if knob.name == super::output::SHOW_LENS.name {
                // The picture stays as it is.
                props.set_int(p::EVALUATE_ON_CHANGE, 0, 0);
            }
            props.set_int(p::ANIMATES, 0, 0);
        }
        Kind::Choice { default, options } => {
            for (index, option) in options.iter().enumerate() {
                props.set_string(p::CHOICE_OPTION, index as i32, option);
            }
            props.set_int(p::DEFAULT, 0, default);
            props.set_int(p::ANIMATES, 0, 0);
        }
        Kind::File => {
            props.set_string(p::STRING_MODE, 0, p::STRING_FILE_PATH);
            props.set_int(p::FILE_PATH_EXISTS, 0, 1);
            props.set_string(p::DEFAULT, 0, c"");
            props.set_int(p::ANIMATES, 0, 0);
        }
        Kind::Text => {
            props.set_string(p::STRING_MODE, 0, p::STRING_SINGLE_LINE);
            props.set_string(p::DEFAULT, 0, c"");
            props.set_int(p::ANIMATES, 0, 0);
        }
        Kind::Button => {}
        Kind::Hidden => {
            props.set_int(p::DEFAULT, 0, 0);
            for (name, value) in [
                (p::MIN, 0),
                (p::MAX, i32::MAX),
                (p::DISPLAY_MIN, 0),
                (p::DISPLAY_MAX, i32::MAX),
            ] {
                props.set_int(name, 0, value);
            }
            // It is never shown: also where descriptors are final.
            props.set_int(p::SECRET, 0, 1);
            props.set_int(p::ANIMATES, 0, 0);
        }
    }
}
