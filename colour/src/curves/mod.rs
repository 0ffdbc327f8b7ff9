//! The project's own curves, gamuts and spaces, in double precision, as `luts/curves.toml` has them.
//!
//! Pictures go through an engine and a config. These are what our own config and its tables are made of, and what they
//! are checked against.

mod form;
mod gamut;
mod table;

pub use form::{CameraLog, Form};
pub use gamut::{Adaptation, Gamut, Matrix};
pub use table::{Curve, OwnSpace, Table};

use std::sync::LazyLock;

use crate::Result;

/// The table as it was when this was built.
const TEXT: &str = include_str!("../../../luts/curves.toml");

/// The project's own table.
///
/// # Errors
/// None but of a build from a table that is not in order.
pub fn own() -> Result<&'static Table> {
    static OWN: LazyLock<Result<Table>> = LazyLock::new(|| Table::parse(TEXT));
    OWN.as_ref().map_err(Clone::clone)
}
