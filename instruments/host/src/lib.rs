//! An adversarial OpenFX host that tests image-filter plugins.
//!
//! It shares no bindings with the plugins it tests, so that it finds their wrong constants and structures.

pub mod causes;
pub mod checks;
pub mod command;
pub mod drive;
pub mod files;
pub mod host;
pub mod panel;
pub mod picture;
mod process;
pub mod render_job;
pub mod result_files;
pub mod runner;
pub mod scene;
pub mod subject;
