//! What knobs are set to at a time.

use super::{Kind, Knob};
use crate::host::{Effect, Params};

/// The knobs of an instance at a time. One that the host does not have stands at its default.
pub(crate) struct Knobs<'h> {
    params: Params<'h>,
    time: f64,
}

impl<'h> Knobs<'h> {
    /// Those of an instance.
    pub(crate) fn of(effect: &Effect<'h>, time: f64) -> Self {
        Self {
            params: effect.params(),
            time,
        }
    }

    /// A number, within its range whatever the host makes of it.
    pub(crate) fn number(&self, knob: &Knob) -> f64 {
        let Kind::Number { default, range, .. } = knob.kind else {
            return 0.0;
        };
        let value = self.params.number(knob.name, self.time);
        let value = value.filter(|value| value.is_finite());
        value.unwrap_or(default).clamp(range.0, range.1)
    }

    pub(crate) fn pair(&self, knob: &Knob) -> (f64, f64) {
        let Kind::Pair { default, .. } = knob.kind else {
            return (0.0, 0.0);
        };
        let value = self.params.pair(knob.name, self.time);
        let sane = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
        value.filter(sane).unwrap_or(default)
    }

    pub(crate) fn is_on(&self, knob: &Knob) -> bool {
        let Kind::Switch(default) = knob.kind else {
            return false;
        };
        let value = self.params.whole(knob.name, self.time);
        value.map_or(default, |value| value != 0)
    }

    /// Which option is chosen: one that there is.
    pub(crate) fn choice(&self, knob: &Knob) -> i32 {
        let Kind::Choice { default, options } = knob.kind else {
            return 0;
        };
        let value = self.params.whole(knob.name, self.time);
        let known = value.filter(|value| (0..options.len() as i32).contains(value));
        known.unwrap_or(default)
    }

    pub(crate) fn text(&self, knob: &Knob) -> String {
        self.params.text(knob.name, self.time).unwrap_or_default()
    }

    /// A whole number that is not shown.
    pub(crate) fn hidden(&self, knob: &Knob) -> i32 {
        self.params.whole(knob.name, self.time).unwrap_or(0)
    }
}
