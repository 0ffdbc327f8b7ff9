//! The report of a diagnosis, as JSON for programs and as a self-contained HTML page for people; the page of a measurement.
//!
//! Pure functions from values to text; commands write the files.

mod advice;
mod headline;
mod json;
mod maps;
mod markup;
pub mod measured;
mod page;
#[cfg(test)]
pub(crate) mod samples;
mod subject;
mod summary;
mod tables;
mod tiles;
mod verdict;
mod words;

pub use json::{json, schema};
pub(crate) use markup::{data_uri, escape, with_code};
pub use page::html;
pub use subject::Subject;
pub use summary::summary;
