//! The sheet of a library lens: its data, its look and its limits.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// The description of a library lens.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// Name without the prefix of the library.
    pub name: String,
    /// A few words for a list.
    pub title: String,
    /// The kind of lens, in a sentence.
    pub kind: String,
    /// Focal length, mm.
    pub focal_length_mm: f64,
    /// The f-number of the profile, wide open, and the largest one that the design is meant for.
    pub f_number_range: [f64; 2],
    /// Focused distance of the profile, m.
    pub focus_distance_m: f64,
    /// Nearest distance of the profile, m.
    pub nearest_m: f64,
    /// Width of the scene over that of its image; 1 for spherical lenses.
    pub squeeze: f64,
    /// The sensor that the profile covers.
    pub sensor: Sensor,
    /// The origin of the numbers of the profile.
    pub computed_from: String,
    /// Aberrations and other effects that the lens shows.
    pub shows: Vec<String>,
    /// Uses that suit the lens.
    pub good_for: Vec<String>,
    /// Properties of real lenses of the kind that the profile lacks.
    pub lacks: Vec<String>,
}

/// The sensor that a library lens covers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    /// Width, mm.
    pub width_mm: f64,
    /// Height, mm.
    pub height_mm: f64,
    /// Columns of the frame in whose pixels the profile is given.
    pub width_px: u32,
    /// Rows of that frame.
    pub height_px: u32,
}

impl Sheet {
    /// Reads a sheet from its JSON text.
    ///
    /// # Errors
    /// Text that is not JSON, and missing and unknown keys.
    pub fn from_json(text: &str) -> Result<Self> {
        serde_json::from_str(text)
            .map_err(|e| Error::new("sheet", format!("is not valid: {e}"), "correct it there"))
    }

    /// Returns the sheet as JSON text.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string_pretty(self).expect("numbers and texts have a JSON form");
        text + "\n"
    }
}

/// The sheet as text: a line for each property, lists below their headings.
impl fmt::Display for Sheet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [open, closed] = self.f_number_range;
        let sensor = &self.sensor;
        writeln!(f, "{}: {}", self.name, self.title)?;
        writeln!(f, "{}", self.kind)?;
        writeln!(f)?;
        writeln!(f, "  focal length  {} mm", self.focal_length_mm)?;
        writeln!(f, "  f-numbers     f/{open} to f/{closed}")?;
        let (focus, nearest) = (self.focus_distance_m, self.nearest_m);
        writeln!(
            f,
            "  focus         {focus} m as designed, nearest {nearest} m"
        )?;
        writeln!(
            f,
            "  sensor        {} x {} mm, {} x {} px",
            sensor.width_mm, sensor.height_mm, sensor.width_px, sensor.height_px
        )?;
        if self.squeeze != 1.0 {
            writeln!(f, "  squeeze       {}x", self.squeeze)?;
        }
        writeln!(f, "  computed from {}", self.computed_from)?;
        let lists = [
            ("Shows", &self.shows),
            ("Good for", &self.good_for),
            ("Lacks", &self.lacks),
        ];
        for (heading, lines) in lists {
            write!(f, "\n{heading}")?;
            for line in lines {
                write!(f, "\n  - {line}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}
