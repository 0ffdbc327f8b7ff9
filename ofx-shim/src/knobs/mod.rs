//! The knobs, which OpenFX calls parameters: those of the core's table, and the node's own, by group; their declaration and
//! their values.
//!
//! Projects store names and the indices of options. Names and the order of options therefore never change, and new
//! options go to the end.

pub(crate) mod colour;
mod core;
mod declare;
pub(crate) mod depth;
pub(crate) mod focus;
pub(crate) mod lens;
pub(crate) mod look;
pub(crate) mod output;
pub(crate) mod relens;
pub(crate) mod remove;
pub(crate) mod render;
mod values;

pub(crate) use core::{named, table};
pub(crate) use declare::declare;
pub(crate) use values::Knobs;

use std::ffi::{CStr, CString};

use seidel_core::HostGroup;

use crate::lens::folder_names;

/// The type of a knob, with its default.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Kind {
    /// A number with its valid range, the range of the slider, and the digits shown after the decimal point.
    Number {
        default: f64,
        range: (f64, f64),
        slider: (f64, f64),
        digits: i32,
    },
    /// Two numbers, or a `position` in canonical coordinates, for which the host may draw a handle.
    Pair { default: (f64, f64), position: bool },
    /// A checkbox.
    Switch(bool),
    /// A menu.
    Choice {
        default: i32,
        options: &'static [&'static CStr],
    },
    /// A menu that sets other knobs, after an entry that chooses nothing.
    Presets(PresetMenu),
    /// The path of an existing file.
    File,
    /// A line of text.
    Text,
    /// A push button.
    Button,
    /// An integer that is not shown.
    Hidden,
}

/// The entries of a menu that sets other knobs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PresetMenu {
    /// The lens profiles in the folder that `SEIDEL_LENSES` names.
    LensFolder,
    /// That of the lens, and the looks with a name.
    Looks,
}

impl PresetMenu {
    /// The entry that chooses nothing.
    const NOTHING: &'static CStr = c"Choose...";

    /// Returns the entries after the one that chooses nothing.
    fn entries(self) -> Vec<CString> {
        match self {
            Self::LensFolder => folder_names(),
            Self::Looks => look::preset_labels(),
        }
    }
}

/// A knob.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Knob {
    pub(crate) name: &'static CStr,
    pub(crate) label: &'static CStr,
    pub(crate) hint: &'static CStr,
    pub(crate) kind: Kind,
}

/// A group of knobs.
pub(crate) struct Group {
    pub(crate) name: &'static CStr,
    pub(crate) label: &'static CStr,
    pub(crate) open: bool,
    /// The node's own knobs.
    pub(crate) own: &'static [Own],
    /// The knobs of the core's table that stand here, too.
    pub(crate) table: Rows,
}

/// Knobs of the core's table.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Rows {
    None,
    /// All of a group.
    Of(HostGroup),
    /// Those of a group that are called so.
    Only(HostGroup, &'static [&'static str]),
    /// Those of a group that are not called so.
    But(HostGroup, &'static [&'static str]),
}

impl Rows {
    /// Returns the knobs, each with its row.
    fn knobs(self) -> impl Iterator<Item = (&'static seidel_core::Knob, &'static Knob)> {
        let (group, names, is_wanted) = match self {
            Self::None => (None, &[][..], false),
            Self::Of(group) => (Some(group), &[][..], false),
            Self::Only(group, names) => (Some(group), names, true),
            Self::But(group, names) => (Some(group), names, false),
        };
        let rows = group.into_iter().flat_map(core::knobs_of);
        rows.filter(move |(row, _)| names.contains(&row.name) == is_wanted)
    }
}

/// A knob of the node's own.
pub(crate) struct Own {
    /// The name in the core's table of the knob before it; empty for the top of the group.
    pub(crate) after: &'static str,
    pub(crate) knob: &'static Knob,
}

impl Own {
    /// A knob at the top of its group.
    pub(crate) const fn first(knob: &'static Knob) -> Self {
        Self { after: "", knob }
    }

    /// A knob after the one that the core's table calls `after`.
    pub(crate) const fn after(after: &'static str, knob: &'static Knob) -> Self {
        Self { after, knob }
    }
}

impl Group {
    /// Returns the knobs in the order in which hosts show them.
    pub(crate) fn knobs(&self) -> Vec<&'static Knob> {
        let own_after = |name: &'static str| {
            let own = self.own.iter().filter(move |own| own.after == name);
            own.map(|own| own.knob)
        };
        let mut knobs: Vec<_> = own_after("").collect();
        for (row, knob) in self.table.knobs() {
            knobs.push(knob);
            knobs.extend(own_after(row.name));
        }
        knobs
    }
}

/// All groups, in the order in which hosts show them.
pub(crate) static ALL: [&Group; 10] = [
    &lens::GROUP,
    &lens::DETAILS,
    &depth::GROUP,
    &focus::GROUP,
    &look::GROUP,
    &output::GROUP,
    &render::GROUP,
    &remove::GROUP,
    &relens::GROUP,
    &colour::GROUP,
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Projects store these names and the indices of options. New lines may be added, and labels and the order of groups may change;
    /// nothing else does.
    #[test]
    fn knobs_keep_their_names_options_and_order() {
        let text = |text: &CStr| text.to_string_lossy().into_owned();
        let mut found = String::new();
        for group in ALL {
            found += &format!("{}\n", text(group.name));
            for knob in group.knobs() {
                let kind = match knob.kind {
                    Kind::Number { default, .. } => format!("number = {default}"),
                    Kind::Pair { default, .. } => format!("pair = {default:?}"),
                    Kind::Switch(default) => format!("switch = {default}"),
                    Kind::Choice { default, options } => {
                        let options: Vec<_> = options.iter().map(|option| text(option)).collect();
                        format!("choice {} = {default}", options.join("|"))
                    }
                    other => format!("{other:?}"),
                };
                found += &format!("  {} ({}): {kind}\n", text(knob.name), text(knob.label));
            }
        }
        assert_eq!(found, include_str!("names.txt"), "found:\n{found}");
    }

    #[test]
    fn names_are_unique_and_defaults_lie_in_their_ranges() {
        let mut names = BTreeSet::new();
        for group in ALL {
            assert!(names.insert(group.name), "{:?}", group.name);
            for knob in group.knobs() {
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
