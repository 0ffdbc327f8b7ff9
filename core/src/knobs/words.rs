//! Ranges, defaults and units of numbers in words.

use super::kind::{Knob, KnobKind, Number, Unit};
use crate::settings::Settings;

impl Unit {
    /// Returns the unit in words; empty for a pure number.
    pub fn words(self) -> &'static str {
        match self {
            Self::Factor | Self::FNumber => "",
            Self::Distance | Self::Metres => "metres",
            Self::Millimetres => "millimetres",
            Self::Micrometres => "micrometres",
            Self::Degrees => "degrees",
            Self::PlatePixels => "plate pixels",
            Self::PlateScale => "plate pixels per pixel of the lens's frame",
            Self::PercentOfFrame => "per cent of the width of the lens's frame",
            Self::SceneLinear => "scene-linear",
        }
    }

    /// Returns the placeholder of a value in the help of the command.
    pub fn placeholder(self) -> &'static str {
        match self {
            Self::Factor => "FACTOR",
            Self::FNumber => "N",
            Self::Distance | Self::Metres => "METRES",
            Self::Millimetres => "MM",
            Self::Micrometres => "UM",
            Self::Degrees => "DEGREES",
            Self::PlatePixels => "PX",
            Self::PlateScale => "RATIO",
            Self::PercentOfFrame => "PERCENT",
            Self::SceneLinear => "VALUE",
        }
    }

    /// Parses a value, without a check of its range. An f-number may begin with `f/`, and infinity is `inf`.
    pub fn parse(self, text: &str) -> Option<f64> {
        let lower = text.trim().to_ascii_lowercase();
        let number = match self {
            Self::FNumber => {
                let number = lower.strip_prefix('f').unwrap_or(&lower);
                number.strip_prefix('/').unwrap_or(number)
            }
            _ => &lower,
        };
        number.trim().parse().ok()
    }
}

impl Number {
    /// Returns the valid values and their unit in words, such as `0 to 0.9` or `above 0 metres, or inf`.
    pub fn range_words(&self) -> String {
        let (least, most) = self.range;
        let range = match (least, most) {
            (f64::MIN_POSITIVE, f64::INFINITY | f64::MAX) => "above 0".to_owned(),
            (f64::MIN_POSITIVE, most) => format!("above 0 and up to {most}"),
            (f64::MIN, f64::MAX) => "a finite number".to_owned(),
            (least, f64::MAX) => format!("{least} or more"),
            (least, most) => format!("{least} to {most}"),
        };
        let unit = self.unit.words();
        let space = if unit.is_empty() { "" } else { " " };
        let infinity = if most == f64::INFINITY {
            ", or inf"
        } else {
            ""
        };
        format!("{range}{space}{unit}{infinity}")
    }

    /// Returns the valid values for a help: the unit alone where the range only keeps out nonsense.
    fn usual_words(&self) -> String {
        let (least, most) = self.range;
        let unit = self.unit.words();
        if most < GUARD && least > -GUARD {
            self.range_words()
        } else if most == f64::INFINITY {
            format!("{unit} or inf")
        } else {
            unit.to_owned()
        }
    }

    /// Returns a value in words.
    fn text(&self, value: Option<f64>) -> String {
        match (value, self.unit) {
            (None, _) => self.absent.to_owned(),
            (Some(f64::INFINITY), Unit::Distance) => "infinity".to_owned(),
            (Some(value), Unit::Distance) => format!("{value} m"),
            (Some(value), _) => value.to_string(),
        }
    }
}

/// Limit of ranges from which on users do not meet it.
const GUARD: f64 = 1e4;

impl Knob {
    /// Returns the help with range, unit and meaning of a number that is left out, as `left_out` calls that: `if omitted`.
    /// It is one sentence without a full stop.
    pub fn summary(&self, left_out: &str) -> String {
        let mut notes = Vec::new();
        if let Some(number) = self.number() {
            notes.push(number.usual_words());
            if !number.absent.is_empty() {
                notes.push(format!("{} {left_out}", number.absent));
            }
        }
        notes.retain(|note| !note.is_empty());
        if notes.is_empty() {
            self.help.to_owned()
        } else {
            format!("{} ({})", self.help, notes.join("; "))
        }
    }

    /// Returns the value of the knob in `settings` in words, for a record of settings.
    pub fn text(&self, settings: &Settings) -> String {
        match &self.kind {
            KnobKind::Number(number) => number.text((number.get)(settings).or(number.default)),
            KnobKind::Choice(choice) => choice.options[(choice.get)(settings)].word.to_owned(),
            KnobKind::Switch(switch) => {
                if (switch.get)(settings) { "on" } else { "off" }.to_owned()
            }
        }
    }
}
