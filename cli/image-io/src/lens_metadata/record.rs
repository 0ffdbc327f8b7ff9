//! The statements of a file about the lens, frame by frame.

use std::collections::BTreeMap;

use serde::Serialize;

use super::number;
use super::time_code::TimeCode;

/// A quantity that a file states about the lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Distance in focus, metres.
    Focus,
    /// Focal length over the diameter of the entrance pupil; a T-number where nothing else is stated.
    FNumber,
    /// Focal length, millimetres.
    FocalLength,
    /// Width of the recorded sensor, millimetres.
    FilmBack,
}

impl Quantity {
    /// All quantities, in the order of messages.
    pub const ALL: [Self; 4] = [
        Self::Focus,
        Self::FNumber,
        Self::FocalLength,
        Self::FilmBack,
    ];

    /// Returns the name of the knob that takes the value, also its column in a table of `--animate`.
    pub fn knob(self) -> &'static str {
        match self {
            Self::Focus => "focus-distance",
            Self::FNumber => "f-number",
            Self::FocalLength => "focal-length-mm",
            Self::FilmBack => "film-back-mm",
        }
    }

    /// Returns the name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Focus => "focus",
            Self::FNumber => "f-number",
            Self::FocalLength => "focal length",
            Self::FilmBack => "film back",
        }
    }

    /// Formats a value with its unit.
    pub fn text(self, value: f64) -> String {
        let value = number::rounded(value);
        match self {
            Self::Focus if value == "inf" => value,
            Self::Focus => format!("{value} m"),
            Self::FNumber => value,
            Self::FocalLength | Self::FilmBack => format!("{value} mm"),
        }
    }
}

/// The source of the unit of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum UnitSource {
    /// The file names the unit beside the value.
    Stated,
    /// The definition of the format names it.
    Defined,
    /// The value counts units of a 3D scene, which the file does not relate to metres.
    Scene,
}

/// A value that a file states, with its place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reading {
    /// The quantity.
    pub quantity: Quantity,
    /// The value in the unit of the quantity, or in scene units.
    pub value: f64,
    /// The source of its unit.
    pub unit: UnitSource,
    /// Whether the value is a T-number.
    pub is_t_stop: bool,
    /// Whether a focus distance is measured from the sensor, not from the entrance pupil.
    pub from_sensor: bool,
    /// Attribute or column, in words.
    pub field: String,
    /// The value as the file writes it, with its unit.
    pub text: String,
}

/// The statements of a file about one frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct FrameRecord {
    /// Number of the frame in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<i64>,
    /// Time code of the frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_code: Option<TimeCode>,
    /// Values, for each quantity the preferred one first.
    pub readings: Vec<Reading>,
    /// Distance of the entrance pupil before the sensor, millimetres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub entrance_pupil_mm: Option<f64>,
    /// Maker, model and serial number of lens and camera, by their names in words.
    pub identity: BTreeMap<&'static str, String>,
    /// Attributes that may concern the lens but are not read, with their values.
    pub unread: BTreeMap<String, String>,
    /// Notes on statements that set nothing, each with its field.
    pub notes: Vec<String>,
}

impl FrameRecord {
    /// Returns whether the file states nothing about lens and camera.
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
            && self.identity.is_empty()
            && self.unread.is_empty()
            && self.notes.is_empty()
    }

    /// Returns the preferred reading of a quantity; one in scene units needs `metres_per_unit`. T-numbers come last.
    pub fn preferred(&self, quantity: Quantity, metres_per_unit: Option<f64>) -> Option<&Reading> {
        let usable = |reading: &&Reading| {
            reading.quantity == quantity
                && (reading.unit != UnitSource::Scene || metres_per_unit.is_some())
        };
        let mut usable = self.readings.iter().filter(usable);
        let first = usable.next()?;
        if !first.is_t_stop {
            return Some(first);
        }
        Some(usable.find(|reading| !reading.is_t_stop).unwrap_or(first))
    }

    /// Returns the value of a reading for the settings of a render: in metres if it counts scene units, and from the entrance
    /// pupil where the file states the place of it.
    pub fn usable_value(&self, reading: &Reading, metres_per_unit: Option<f64>) -> f64 {
        let scale = match reading.unit {
            UnitSource::Scene => metres_per_unit.unwrap_or(1.0).abs(),
            UnitSource::Stated | UnitSource::Defined => 1.0,
        };
        match self.entrance_pupil_mm {
            Some(pupil) if reading.from_sensor && reading.quantity == Quantity::Focus => {
                // Rounded, so that decimal numbers stay decimal.
                number::decimal(reading.value - pupil / 1000.0)
            }
            _ if scale == 1.0 => reading.value,
            _ => number::decimal(reading.value * scale),
        }
    }
}
