//! The report of a diagnosis: JSON for programs, and a self-contained HTML page for people.
//!
//! Pure functions from values to text; files are written elsewhere.

mod headline;
mod json;
#[cfg(test)]
pub(crate) mod made;
mod maps;
mod markup;
mod page;
mod subject;
mod tables;
mod tiles;
mod words;

pub use json::{json, schema};
pub use page::html;
pub use subject::Subject;
