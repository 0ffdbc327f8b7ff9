//! The knobs: the settings that the command, the C ABI, OpenFX hosts and Python offer. Each is a row of a table, which
//! alone states its range, default, unit and help.

mod choice;
mod focus;
mod kind;
mod lens;
mod look;
mod preset;
mod removal;
mod render;
mod sides;
mod words;

pub use choice::{Choice, ChoiceOption};
pub use kind::{
    HostGroup, HostKnob, Knob, KnobKind, KnobScope, KnobUse, Mode, Number, Relation, Switch, Unit,
};
pub use preset::LookPreset;

use seidel_optics::error::Result;

use crate::settings::Settings;

impl Knob {
    /// Returns all knobs, in the order in which hosts show them. A knob comes after those that it depends on.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        let tables = [
            lens::KNOBS,
            focus::KNOBS,
            look::KNOBS,
            render::KNOBS,
            removal::KNOBS,
            sides::FROM,
            sides::TO,
        ];
        tables.into_iter().flatten()
    }

    /// Returns the numbers of a [`Look`](crate::Look), each with its default.
    pub fn numbers_of_look() -> impl Iterator<Item = (&'static Self, f64)> {
        let knobs = Self::all().filter(|knob| knob.is_of_look());
        knobs.filter_map(|knob| Some((knob, knob.number()?.default?)))
    }

    /// Returns the knob called `name`.
    pub fn named(name: &str) -> Option<&'static Self> {
        Self::all().find(|knob| knob.name == name)
    }
}

/// Checks that all numbers of `settings` are in their ranges.
///
/// # Errors
/// A number out of its range, by the name of its knob.
pub(crate) fn check(settings: &Settings) -> Result<()> {
    Knob::all().try_for_each(|knob| match &knob.kind {
        KnobKind::Number(number) => match (number.get)(settings) {
            Some(value) => knob.check(value),
            None => Ok(()),
        },
        KnobKind::Choice(_) | KnobKind::Switch(_) => Ok(()),
    })
}

#[cfg(test)]
mod tests;
