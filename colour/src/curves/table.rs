//! The table of curves, gamuts and spaces.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::{Gamut, TransferFunction};
use crate::{ColourError, Result};

/// The name of the table in messages.
const NAME: &str = "luts/curves.toml";

/// The table at build time.
const EMBEDDED: &str = include_str!("../../../luts/curves.toml");

/// Transfer functions, gamuts, and the colour spaces made of them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurveTable {
    /// Curves by name.
    #[serde(rename = "curve")]
    pub curves: BTreeMap<String, Curve>,
    /// Gamuts by name.
    #[serde(rename = "gamut")]
    pub gamuts: BTreeMap<String, Gamut>,
    /// Spaces, in the order of the config.
    #[serde(rename = "space")]
    pub spaces: Vec<SpaceDefinition>,
}

/// A transfer function and its source.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Curve {
    /// Document that defines it.
    pub document: String,
    /// Revision of the document.
    pub revision: String,
    /// Code of 18 % grey according to the manufacturer.
    pub grey: f64,
    /// The function.
    #[serde(flatten)]
    pub transfer: TransferFunction,
}

/// A colour space of Seidel's own config.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpaceDefinition {
    /// Its name.
    pub name: String,
    /// Its other names.
    #[serde(default)]
    pub aliases: Vec<String>,
    /// Its place in menus.
    pub family: String,
    /// Name of its curve; the space is linear without one.
    pub curve: Option<String>,
    /// Name of its gamut.
    pub gamut: String,
    /// OpenColorIO encoding; by default `log` with a curve and `scene-linear` without.
    pub encoding: Option<String>,
    /// OpenColorIO's built-in transform, for a curve that no parametric transform of a v2.1 config can express.
    pub builtin: Option<String>,
    /// Display that shows this space.
    pub display: Option<String>,
    /// File name, without extension, of the 1D table generated from its curve.
    pub table: Option<String>,
}

impl CurveTable {
    /// Returns Seidel's own table.
    ///
    /// # Errors
    /// If `luts/curves.toml` was invalid at build time.
    pub fn embedded() -> Result<&'static Self> {
        static TABLE: LazyLock<Result<CurveTable>> = LazyLock::new(|| CurveTable::parse(EMBEDDED));
        TABLE.as_ref().map_err(Clone::clone)
    }

    /// Parses a table.
    ///
    /// # Errors
    /// If the text is not such a table, or a space names a curve or gamut that it lacks.
    pub fn parse(text: &str) -> Result<Self> {
        let table: Self = toml::from_str(text).map_err(|e| {
            let problem = e.to_string().trim_end().replace('\n', " ");
            ColourError::new(NAME, "", problem, "correct the line")
        })?;
        for space in &table.spaces {
            table.gamut(space)?;
            table.curve(space)?;
        }
        Ok(table)
    }

    /// Returns the gamut of a space.
    ///
    /// # Errors
    /// If the table lacks it.
    pub fn gamut(&self, space: &SpaceDefinition) -> Result<&Gamut> {
        let gamut = self.gamuts.get(&space.gamut);
        gamut.ok_or_else(|| missing(space, "gamut", &space.gamut))
    }

    /// Returns the curve of a space, or nothing for a linear space.
    ///
    /// # Errors
    /// If the table lacks it.
    pub fn curve(&self, space: &SpaceDefinition) -> Result<Option<&Curve>> {
        let Some(name) = &space.curve else {
            return Ok(None);
        };
        let curve = self.curves.get(name);
        curve.map(Some).ok_or_else(|| missing(space, "curve", name))
    }

    /// Returns the space of this name.
    pub fn space(&self, name: &str) -> Option<&SpaceDefinition> {
        self.spaces.iter().find(|space| space.name == name)
    }
}

fn missing(space: &SpaceDefinition, kind: &str, name: &str) -> ColourError {
    ColourError::new(
        NAME,
        format!("space `{}`", space.name),
        format!("unknown {kind} `{name}`"),
        format!("add [{kind}.{name}], or name another {kind}"),
    )
}
