//! The table of curves, gamuts and spaces as it is kept.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{Form, Gamut};
use crate::{ColourError, Result};

/// What the table is called in messages.
const NAME: &str = "luts/curves.toml";

/// The table.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Curves by their names.
    #[serde(rename = "curve")]
    pub curves: BTreeMap<String, Curve>,
    /// Gamuts by their names.
    #[serde(rename = "gamut")]
    pub gamuts: BTreeMap<String, Gamut>,
    /// Spaces, in the order of the config.
    #[serde(rename = "space")]
    pub spaces: Vec<OwnSpace>,
}

/// A curve and where it comes from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Curve {
    /// Where its numbers stand.
    pub document: String,
    /// Which revision of it.
    pub revision: String,
    /// The code of 18 % grey by the maker's own table.
    pub grey: f64,
    /// What it is.
    #[serde(flatten)]
    pub form: Form,
}

/// A space of the project's own config.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnSpace {
    /// Its name.
    pub name: String,
    /// Other names for it.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// Its place in menus.
    pub family: String,
    /// Its curve; linear if none.
    pub curve: Option<String>,
    /// Its gamut.
    pub gamut: String,
    /// What its codes are, where that is not a logarithm or linear.
    pub encoding: Option<String>,
    /// The transform of OpenColorIO's own that the config has instead, where no other gives the curve.
    pub builtin: Option<String>,
    /// The display that is sent its codes.
    pub display: Option<String>,
    /// The name of the table that is made of its curve.
    pub table: Option<String>,
}

impl Table {
    /// Reads a table.
    ///
    /// # Errors
    /// A text that is no such table, and spaces of curves or gamuts that it lacks.
    pub fn parse(text: &str) -> Result<Self> {
        let table: Self = toml::from_str(text).map_err(|e| {
            let problem = e.to_string().trim_end().replace('\n', " ");
            ColourError::new(NAME, "", problem, "mend the line")
        })?;
        for space in &table.spaces {
            table.gamut(space)?;
            table.curve(space)?;
        }
        Ok(table)
    }

    /// The gamut of a space.
    ///
    /// # Errors
    /// One that is not in the table.
    pub fn gamut(&self, space: &OwnSpace) -> Result<&Gamut> {
        (self.gamuts.get(&space.gamut)).ok_or_else(|| missing(space, "gamut", &space.gamut))
    }

    /// The curve of a space, where it has one.
    ///
    /// # Errors
    /// One that is not in the table.
    pub fn curve(&self, space: &OwnSpace) -> Result<Option<&Curve>> {
        let curve = space.curve.as_ref();
        let of = |name: &String| {
            let curve = self.curves.get(name);
            curve.ok_or_else(|| missing(space, "curve", name))
        };
        curve.map(of).transpose()
    }

    /// The space of this name.
    pub fn space(&self, name: &str) -> Option<&OwnSpace> {
        self.spaces.iter().find(|space| space.name == name)
    }
}

fn missing(space: &OwnSpace, what: &str, name: &str) -> ColourError {
    ColourError::new(
        NAME,
        format!("space `{}`", space.name),
        format!("has the {what} `{name}`, which is not there"),
        format!("add [{what}.{name}], or name another"),
    )
}
