//! Values of the knobs of an instance.

use seidel_core::{HostGroup, KnobKind, Settings, Unit};

use super::core::knobs_of;
use super::{Kind, Knob};
use crate::geometry::PlateScale;
use crate::host::{Effect, Failure, ParameterSet, Result};

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

    /// Returns the number of the frame.
    pub(crate) fn frame(&self) -> i64 {
        self.time.round() as i64
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

    /// Writes the knobs of a group of the core's table to `settings`. Numbers of plate pixels are for a plate of this `scale`.
    ///
    /// # Errors
    /// A number out of its range, by its label.
    pub(crate) fn put(
        &self,
        group: HostGroup,
        scale: PlateScale,
        settings: &mut Settings,
    ) -> Result<()> {
        let mut knobs = knobs_of(group);
        knobs.try_for_each(|(row, knob)| self.put_knob(row, knob, scale, settings))
    }

    /// Writes a knob of the core's table to `settings`.
    pub(crate) fn put_knob(
        &self,
        row: &seidel_core::Knob,
        knob: &Knob,
        scale: PlateScale,
        settings: &mut Settings,
    ) -> Result<()> {
        let put = match &row.kind {
            KnobKind::Number(number) => {
                let value = self.number(knob);
                let is_left_out = number.default.is_none() && value == 0.0;
                let in_pixels = matches!(number.unit, Unit::PlatePixels | Unit::PlateScale);
                let value = if in_pixels { value * scale.y } else { value };
                if is_left_out {
                    return Ok(());
                }
                row.put_number(value, settings)
            }
            KnobKind::Choice(_) => row.put_index(self.choice(knob) as usize, settings),
            KnobKind::Switch(_) => row.put_index(usize::from(self.is_on(knob)), settings),
        };
        put.map_err(|e| {
            let label = knob.label.to_string_lossy();
            Failure::failed(format!("{label}: {}; {}", e.problem, e.remedy))
        })
    }

    /// Returns an integer that is not shown.
    pub(crate) fn hidden(&self, knob: &Knob) -> i32 {
        self.parameters.int(knob.name, self.time).unwrap_or(0)
    }
}
