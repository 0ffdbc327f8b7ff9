//! An OpenFX host that is nasty on purpose, and its checks of image-filter plugins.
//!
//! It shares no binding with the plugins it is made for, so that a wrong constant or structure of theirs shows.

pub mod checks;
pub mod command;
pub mod drive;
pub mod files;
pub mod host;
pub mod picture;
pub mod scene;
pub mod shot;
pub mod subject;
pub mod subjects;
