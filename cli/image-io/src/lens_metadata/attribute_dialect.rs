//! The names that a program gives to the attributes of lens and camera.

use super::number;
use super::record::{FrameRecord, Quantity};
use crate::part::Part;

/// The attributes that a program writes about lens and camera.
pub(super) struct Dialect {
    /// Attributes of values, for each quantity the preferred one first.
    pub(super) rows: &'static [Row],
    /// Attributes about the makers of lens and camera, each with its name in words.
    pub(super) identity: &'static [(&'static str, &'static str)],
    /// Adds the values that several attributes state together.
    pub(super) combine: fn(&Attributes, &mut FrameRecord),
}

/// An attribute that states a quantity.
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) quantity: Quantity,
    pub(super) unit: Unit,
}

/// The meaning of the number in an attribute.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unit {
    /// Metres from the sensor.
    MetresFromSensor,
    Millimetres,
    FNumber,
    TNumber,
    /// Units of the scene, from the entrance pupil.
    Scene,
}

/// The attributes of a part.
pub(super) struct Attributes<'a> {
    pub(super) part: &'a Part,
    /// Added to the names of attributes of a part that is not the beauty pass.
    pub(super) suffix: String,
}

impl Attributes<'_> {
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        let mut attributes = self.part.attributes.iter();
        let (_, text) = attributes.find(|(own, _)| own == name)?;
        Some(text.trim())
    }

    /// Returns the numbers of an attribute.
    pub(super) fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let words = self.text(name)?.split_whitespace();
        words.map(number::parse).collect()
    }

    /// Returns the words for an attribute in messages.
    pub(super) fn field(&self, name: &str) -> String {
        format!("attribute `{name}`{}", self.suffix)
    }
}
