//! A diagnosis put down: as JSON for programs, as one page for people; `self_test`: many of them likewise.
//!
//! Pure functions from values to text; files are written elsewhere.

mod headline;
mod json;
#[cfg(test)]
pub(crate) mod made;
mod maps;
mod markup;
mod page;
pub mod self_test;
mod subject;
mod tables;
mod tiles;
mod words;

pub use json::{json, schema};
pub use page::html;
pub use subject::Subject;
