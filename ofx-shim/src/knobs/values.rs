//! Values of the knobs of an instance.

use super::{Kind, Knob};
use crate::host::{Effect, ParameterSet};

/// The knobs of an instance at a time. A knob that the host does not support has its default value.
pub(crate) struct Knobs<'h> {
    parameters: ParameterSet<'h>,
    time: f64,
}

impl<'h> Knobs<'h> {
    /// The knobs of `effect` at `time`.
    pub(crate) fn at(effect: &Effect<'h>, time: f64) -> Self {
        Self {
            parameters: effect.parameters(),
            time,
        }
    }

    /// Returns a number, clamped to its range.
    pub(crate) fn number(&self, knob: &Knob) -> f64 {
        let Kind::Number { default, range, .. } = knob.kind else {
            return 0.0;
        };
        let value = self.parameters.double(knob.name, self.time);
        let value = value.filter(|value| value.is_finite());
        value.unwrap_or(default).clamp(range.0, range.1)
    }

    pub(crate) fn pair(&self, knob: &Knob) -> (f64, f64) {
        let Kind::Pair { default, .. } = knob.kind else {
            return (0.0, 0.0);
        };
        let value = self.parameters.double_2d(knob.name, self.time);
        let value = value.filter(|(x, y)| x.is_finite() && y.is_finite());
        value.unwrap_or(default)
    }

    pub(crate) fn is_on(&self, knob: &Knob) -> bool {
        let Kind::Switch(default) = knob.kind else {
            return false;
        };
        let value = self.parameters.int(knob.name, self.time);
        value.map_or(default, |value| value != 0)
    }

    /// Returns the index of the chosen option; the default if the host's index has no option.
    pub(crate) fn choice(&self, knob: &Knob) -> i32 {
        let Kind::Choice { default, options } = knob.kind else {
            return 0;
        };
        let value = self.parameters.int(knob.name, self.time);
        let valid = value.filter(|value| (0..options.len() as i32).contains(value));
        valid.unwrap_or(default)
    }

    pub(crate) fn text(&self, knob: &Knob) -> String {
        let value = self.parameters.string(knob.name, self.time);
        value.unwrap_or_default()
    }

    /// Returns an integer that is not shown.
    pub(crate) fn hidden(&self, knob: &Knob) -> i32 {
        self.parameters.int(knob.name, self.time).unwrap_or(0)
    }
}
