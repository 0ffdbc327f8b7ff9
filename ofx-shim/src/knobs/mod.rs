//! The knobs: what can be set, group by group. Names, and the order of what can be chosen, are kept by projects: they
//! never change, and choices grow at their end only.

pub(crate) mod colour;
mod declare;
pub(crate) mod depth;
pub(crate) mod focus;
pub(crate) mod lens;
pub(crate) mod output;
mod read;
pub(crate) mod remove;
pub(crate) mod render;

pub(crate) use declare::declare;
pub(crate) use read::Knobs;

use std::ffi::CStr;

/// What a knob holds.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// A number: its default, hard range, range of the slider, and decimals shown.
    Number {
        default: f64,
        range: (f64, f64),
        slider: (f64, f64),
        digits: i32,
    },
    /// Two numbers; `position`: where something is, canonical, with a handle of the host's.
    Pair { default: (f64, f64), position: bool },
    /// On or off.
    Switch(bool),
    /// One of several.
    Choice {
        default: i32,
        options: &'static [&'static CStr],
    },
    /// A file that is there.
    File,
    /// A line of words.
    Text,
    /// Something to press.
    Button,
    /// A number that is not shown.
    Hidden,
}

/// A knob.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Knob {
    pub(crate) name: &'static CStr,
    pub(crate) label: &'static CStr,
    pub(crate) hint: &'static CStr,
    pub(crate) kind: Kind,
}

/// Knobs that stand together.
pub(crate) struct Group {
    pub(crate) name: &'static CStr,
    pub(crate) label: &'static CStr,
    pub(crate) open: bool,
    pub(crate) knobs: &'static [&'static Knob],
}

/// All, in the order in which they are shown.
pub(crate) static ALL: [&Group; 7] = [
    &lens::GROUP,
    &depth::GROUP,
    &focus::GROUP,
    &colour::GROUP,
    &render::GROUP,
    &remove::GROUP,
    &output::GROUP,
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn names_are_single_and_defaults_lie_in_their_ranges() {
        let mut names = BTreeSet::new();
        for group in ALL {
            assert!(names.insert(group.name), "{:?}", group.name);
            for knob in group.knobs {
                assert!(names.insert(knob.name), "{:?}", knob.name);
                assert!(!knob.label.to_bytes().contains(&b'-'), "{:?}", knob.label);
                match knob.kind {
                    Kind::Number {
                        default,
                        range,
                        slider,
                        ..
                    } => {
                        assert!((range.0..=range.1).contains(&default), "{:?}", knob.name);
                        assert!(range.0 <= slider.0 && slider.0 < slider.1 && slider.1 <= range.1);
                    }
                    Kind::Choice { default, options } => {
                        assert!((0..options.len() as i32).contains(&default));
                    }
                    _ => {}
                }
            }
        }
    }
}
