//! Image files, observation sets and profiles: reading, conversion and whole-or-nothing writing.
#![forbid(unsafe_code)]

pub mod atomic;
mod colour_space;
pub mod depth;
pub mod description;
mod dpx;
pub mod error;
pub mod exr;
mod facts;
pub mod flat_plate;
pub mod format;
mod guard;
mod hdr;
mod jpeg;
pub mod json;
mod limits;
pub mod lut_file;
pub mod matte;
pub mod observation_set;
mod other_format;
pub mod picture;
pub mod plate;
mod png;
pub mod provenance;
pub mod residual;
pub mod sequence;
mod text_lines;
mod tiff;
mod tile_image;
pub mod windows;

pub use error::{FileError, Result};

#[cfg(test)]
mod tests;
