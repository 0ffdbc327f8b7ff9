//! A diagnosis put down: as JSON for programs, as one page for people.
//!
//! Pure functions from values to text; files are written elsewhere.

mod json;
#[cfg(test)]
pub(crate) mod made;
mod subject;

pub use json::{json, schema};
pub use subject::Subject;
