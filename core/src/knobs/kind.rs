//! A row of the table of knobs.

use seidel_optics::error::{Error, Result};

use super::choice::Choice;
use crate::lens::Lens;
use crate::settings::Settings;

/// A knob: a setting that all surfaces offer.
#[derive(Debug)]
pub struct Knob {
    /// The option of the command. With `_` for `-` the member of the C struct and the attribute in Python.
    pub name: &'static str,
    /// The knob of an OpenFX node; `None` where the node has knobs of its own for the setting.
    pub host: Option<HostKnob>,
    /// The commands that have the option.
    pub scope: KnobScope,
    /// One sentence without a full stop, for all surfaces.
    pub help: &'static str,
    /// More sentences for long helps; empty if there are none.
    pub details: &'static str,
    /// Its relation to another knob.
    pub relation: Relation,
    /// Type, range and default.
    pub kind: KnobKind,
    /// Returns whether the knob changes a result.
    pub has_effect: fn(&KnobUse) -> bool,
}

/// The relation of a knob to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// None.
    None,
    /// It has no effect unless the setting of this name is given.
    Needs(&'static str),
    /// It replaces the knob of this name: only one of the two may be given.
    Replaces(&'static str),
}

/// A knob of an OpenFX node.
#[derive(Debug)]
pub struct HostKnob {
    /// The name that projects store.
    pub name: &'static str,
    /// The label.
    pub label: &'static str,
    /// The group of knobs.
    pub group: HostGroup,
}

/// A group of knobs of an OpenFX node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HostGroup {
    /// The lens, its strength and its frame.
    Lens,
    /// The range in focus.
    Focus,
    /// Artistic changes of the lens.
    Look,
    /// Accuracy, edges and occlusion.
    Render,
    /// Noise, clipping and strength of a removal.
    Remove,
    /// The two lenses of a relens.
    Relens,
}

/// The commands that have the option of a knob.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KnobScope {
    /// All commands that draw a lens.
    Lens,
    /// Those on plates: `apply`, `remove` and `relens`.
    Plates,
    /// Those that give a plate the blur of a lens: `apply` and `relens`.
    NewBlur,
    /// `apply`.
    Apply,
    /// Those that remove blur: `remove` and `relens`.
    Removal,
    /// `remove`.
    Remove,
    /// `relens`.
    Relens,
}

/// Type, range and default of a knob, and its place in [`Settings`].
#[derive(Debug)]
pub enum KnobKind {
    /// A number.
    Number(Number),
    /// One of several words.
    Choice(Choice),
    /// On or off.
    Switch(Switch),
}

/// A knob that is a number.
#[derive(Debug)]
pub struct Number {
    /// Unit of the value.
    pub unit: Unit,
    /// Smallest and largest value.
    pub range: (f64, f64),
    /// The default; `None` leaves the setting out.
    pub default: Option<f64>,
    /// The meaning of a number that is left out, such as `as measured`; empty if it cannot be.
    pub absent: &'static str,
    /// The usual values, for a slider.
    pub slider: (f64, f64),
    /// Digits after the decimal point that hosts show.
    pub digits: u8,
    /// Reads the number from settings.
    pub get: fn(&Settings) -> Option<f64>,
    /// Writes the number, which is in its range, to settings. Settings of knobs that it depends on are there already.
    pub set: fn(&mut Settings, f64),
}

/// The unit of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// A pure number.
    Factor,
    /// A focal length over the diameter of the pupil.
    FNumber,
    /// A distance from the camera, metres; may be infinite. Its reciprocal is interpolated.
    Distance,
    /// A length, metres.
    Metres,
    /// A length, millimetres.
    Millimetres,
    /// A length, micrometres.
    Micrometres,
    /// An angle, degrees.
    Degrees,
    /// A length on the plate, pixels.
    PlatePixels,
    /// Plate pixels per pixel of the lens's frame.
    PlateScale,
    /// A length, per cent of the width of the lens's frame.
    PercentOfFrame,
    /// A scene-linear value.
    SceneLinear,
}

/// A knob that is on or off.
#[derive(Debug)]
pub struct Switch {
    /// The default.
    pub default: bool,
    /// Reads the switch from settings.
    pub get: fn(&Settings) -> bool,
    /// Writes the switch to settings.
    pub set: fn(&mut Settings, bool),
}

/// The work that settings are used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Blur is applied.
    Apply,
    /// Blur is removed.
    Remove,
    /// Blur is replaced by that of another lens.
    Relens,
}

/// The circumstances that decide whether a knob has an effect. A lens that is not known counts as one that can do all.
pub struct KnobUse<'a> {
    /// The work.
    pub mode: Mode,
    /// The lens that the plate was taken with, or whose blur it gets.
    pub lens: Option<&'a Lens>,
    /// The lens whose look is changed.
    pub look_lens: Option<&'a Lens>,
    /// The settings.
    pub settings: &'a Settings,
}

impl KnobUse<'_> {
    pub(super) fn lens_is_none_or(&self, is_met: impl FnOnce(&Lens) -> bool) -> bool {
        self.lens.is_none_or(is_met)
    }

    pub(super) fn has_rays(&self) -> bool {
        self.lens_is_none_or(|lens| lens.predictor().has_rays())
    }

    pub(super) fn is_removal(&self) -> bool {
        self.mode != Mode::Apply
    }

    pub(super) fn has_look(&self) -> bool {
        self.mode != Mode::Remove
    }

    pub(super) fn has_look_of_rays(&self) -> bool {
        self.has_look() && (self.look_lens).is_none_or(|lens| lens.predictor().has_rays())
    }
}

impl Knob {
    /// A knob that hosts do not show, has no relation to others, and always has an effect.
    pub(super) const fn new(
        name: &'static str,
        scope: KnobScope,
        help: &'static str,
        kind: KnobKind,
    ) -> Self {
        Self {
            name,
            host: None,
            scope,
            help,
            details: "",
            relation: Relation::None,
            kind,
            has_effect: |_| true,
        }
    }

    /// The knob in a group of hosts, by its name there and its label.
    pub(super) const fn in_hosts(self, group: HostGroup, [name, label]: [&'static str; 2]) -> Self {
        let host = Some(HostKnob { name, label, group });
        Self { host, ..self }
    }

    /// Returns the name as an identifier: that of the C member and of the Python attribute.
    pub fn identifier(&self) -> String {
        self.name.replace('-', "_")
    }

    /// Returns whether the knob is a number of the [`Look`](crate::Look) of a lens. Bloom is none: it is of any lens.
    pub fn is_of_look(&self) -> bool {
        self.scope == KnobScope::NewBlur && !self.name.starts_with("bloom")
    }

    /// Returns the number that the knob is, if it is one.
    pub fn number(&self) -> Option<&Number> {
        match &self.kind {
            KnobKind::Number(number) => Some(number),
            KnobKind::Choice(_) | KnobKind::Switch(_) => None,
        }
    }

    /// Checks that the knob that this one replaces is not given as well.
    ///
    /// # Errors
    /// The name of this knob, if `is_given` says that the other is.
    pub fn check_alone(&self, is_given: impl FnOnce(&'static Self) -> bool) -> Result<()> {
        let Relation::Replaces(name) = self.relation else {
            return Ok(());
        };
        match Self::named(name) {
            Some(other) if is_given(other) => Err(Error::new(
                self.name,
                format!("is given beside {}", other.identifier()),
                "leave one of the two out",
            )),
            _ => Ok(()),
        }
    }

    /// Checks that a number is in the range of the knob.
    ///
    /// # Errors
    /// A value out of the range, and one that is not a number, by the name of the knob.
    pub fn check(&self, value: f64) -> Result<()> {
        let Some(number) = self.number() else {
            return Ok(());
        };
        let (least, most) = number.range;
        if (least..=most).contains(&value) {
            return Ok(());
        }
        let remedy = format!("give {}", number.range_words());
        Err(Error::new(self.name, format!("is {value}"), remedy))
    }

    /// Checks a number and writes it to `settings`.
    ///
    /// # Errors
    /// Those of [`Self::check`].
    pub fn put_number(&self, value: f64, settings: &mut Settings) -> Result<()> {
        self.check(value)?;
        if let Some(number) = self.number() {
            (number.set)(settings, value);
        }
        Ok(())
    }

    /// Writes the option at `index` of a choice, or the state of a switch, to `settings`.
    ///
    /// # Errors
    /// An index without an option.
    pub fn put_index(&self, index: usize, settings: &mut Settings) -> Result<()> {
        let count = match &self.kind {
            KnobKind::Number(_) => 0,
            KnobKind::Choice(choice) => choice.options.len(),
            KnobKind::Switch(_) => 2,
        };
        if index >= count {
            let remedy = format!("give 0 to {}", count.saturating_sub(1));
            return Err(Error::new(self.name, format!("is {index}"), remedy));
        }
        match &self.kind {
            KnobKind::Number(_) => {}
            KnobKind::Choice(choice) => (choice.set)(settings, index),
            KnobKind::Switch(switch) => (switch.set)(settings, index == 1),
        }
        Ok(())
    }
}
