//! Attributes that a user names: those of cameras and studios whose meaning no dialect knows.

use std::path::Path;
use std::str::FromStr;

use super::number;
use super::record::{FrameRecord, Quantity, Reading, UnitSource};
use crate::description::Description;
use crate::error::{FileError, Result};
use crate::part::Part;

/// An attribute, the quantity that it states, and the unit of its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedAttribute {
    quantity: Quantity,
    name: String,
    /// Unit of a length, or `T` for a T-number; `None` for the unit of the quantity, or that in the text.
    unit: Option<String>,
}

/// The name of a T-number among units.
const T_NUMBER: &str = "T";

const NAMES: [(&str, Quantity); 4] = [
    ("focus", Quantity::Focus),
    ("f-number", Quantity::FNumber),
    ("focal-length", Quantity::FocalLength),
    ("film-back", Quantity::FilmBack),
];

impl FromStr for NamedAttribute {
    type Err = String;

    /// Parses `focus=NAME`, or with a unit `focus=NAME:mm`. Names may contain colons.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let remedy = "give focus, f-number, focal-length or film-back, then = and the name of the attribute, and if it needs one : and a unit (m, cm, mm, in, ft, or T for a T-number)";
        let (quantity, name) = text.split_once('=').ok_or(remedy)?;
        let row = NAMES.iter().find(|(own, _)| *own == quantity.trim());
        let (_, quantity) = *row.ok_or(remedy)?;
        let is_unit = |unit: &str| match quantity {
            Quantity::FNumber => unit == T_NUMBER,
            _ => number::millimetres_per(unit).is_some(),
        };
        let (name, unit) = match name.rsplit_once(':') {
            Some((name, unit)) if is_unit(unit) => (name, Some(unit.to_owned())),
            _ => (name, None),
        };
        if name.is_empty() {
            return Err(remedy.to_owned());
        }
        Ok(Self {
            quantity,
            name: name.to_owned(),
            unit,
        })
    }
}

impl NamedAttribute {
    /// Returns the statement of the attribute in `parts`.
    fn reading(&self, parts: &[Part]) -> Option<Reading> {
        let mut attributes = parts.iter().flat_map(|part| &part.attributes);
        let (_, text) = attributes.find(|(name, _)| *name == self.name)?;
        let text = text.trim();
        let unit = self.unit.as_deref();
        let (value, is_t_stop) = match self.quantity {
            Quantity::FNumber => {
                let stop = number::parse_stop(text);
                let is_t = stop
                    .as_ref()
                    .and_then(|stop| stop.is_t_stop)
                    .unwrap_or(false);
                (stop.map(|stop| stop.value), is_t || unit == Some(T_NUMBER))
            }
            _ => (self.length(text), false),
        };
        let shown = match unit {
            Some(unit) => format!("{text} {unit}"),
            None => text.to_owned(),
        };
        Some(Reading {
            quantity: self.quantity,
            // Refused as it stands, if it is not a number.
            value: value.unwrap_or(f64::NAN),
            unit: UnitSource::Stated,
            is_t_stop,
            from_sensor: self.quantity == Quantity::Focus,
            field: self.field(),
            text: shown,
        })
    }

    /// Returns a length in the unit of the quantity.
    fn length(&self, text: &str) -> Option<f64> {
        let length = number::parse_length(text)?;
        let own = match self.quantity {
            Quantity::Focus => "m",
            _ => "mm",
        };
        let unit = match (length.unit, self.unit.as_deref()) {
            ("", Some(unit)) => unit,
            ("", None) => own,
            (unit, _) => unit,
        };
        let scale = number::millimetres_per(unit)? / number::millimetres_per(own)?;
        Some(match scale == 1.0 {
            true => length.value,
            false => number::decimal(length.value * scale),
        })
    }

    fn field(&self) -> String {
        format!("attribute `{}`", self.name)
    }

    /// Puts the statements of the attributes in the file at `path` before all others of `record`.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read_all(named: &[Self], path: &Path, record: &mut FrameRecord) -> Result<()> {
        if named.is_empty() {
            return Ok(());
        }
        let description = Description::read(path)?;
        let readings = named
            .iter()
            .filter_map(|own| own.reading(&description.parts));
        record.readings.splice(0..0, readings);
        Ok(())
    }

    /// Checks that one of the `records` of the shot, the first from the file at `first`, has each attribute.
    ///
    /// # Errors
    /// An attribute that no frame has.
    pub fn check_found<'r>(
        named: &[Self],
        records: impl Iterator<Item = &'r FrameRecord> + Clone,
        first: &Path,
    ) -> Result<()> {
        for own in named {
            let field = own.field();
            let mut readings = records.clone().flat_map(|record| &record.readings);
            if !readings.any(|reading| reading.field == field) {
                return Err(FileError::new(
                    first,
                    field,
                    "does not exist",
                    "give the name of an attribute as `seidel info` lists it",
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_named_with_quantity_and_unit() {
        let part = |text: &str| Part {
            name: None,
            size: (1, 1),
            channels: Vec::new(),
            storage: Vec::new(),
            attributes: vec![("show:lens".to_owned(), text.to_owned())],
            provenance: Vec::new(),
        };
        for (option, text, value, is_t_stop) in [
            ("focus=show:lens", "3.2", 3.2, false),
            ("focus=show:lens:mm", "3200", 3.2, false),
            ("focus=show:lens:ft", "10.5", 3.2004, false),
            ("focus=show:lens", "320cm", 3.2, false),
            ("f-number=show:lens", "f/2.8", 2.8, false),
            ("f-number=show:lens:T", "2.9", 2.9, true),
            ("f-number=show:lens", "T2.9", 2.9, true),
            ("focal-length=show:lens", "40", 40.0, false),
            ("film-back=show:lens:in", "1", 25.4, false),
        ] {
            let named: NamedAttribute = option.parse().expect(option);
            let reading = named.reading(&[part(text)]).expect("there");
            assert_eq!(
                (reading.value, reading.is_t_stop),
                (value, is_t_stop),
                "{option}"
            );
            assert_eq!(reading.field, "attribute `show:lens`");
        }
        let named: NamedAttribute = "focus=other".parse().expect("an option");
        assert_eq!(named.reading(&[part("3")]), None);
        for bad in ["", "focus", "focus=", "iris=a", "focus=:mm"] {
            assert!(bad.parse::<NamedAttribute>().is_err(), "{bad}");
        }
    }
}
