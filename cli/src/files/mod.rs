//! Everything the command reads and writes: the only room where files are opened.

pub mod animation;
pub mod atomic;
mod colour_space;
pub mod depth;
pub mod description;
mod dpx;
pub mod error;
pub mod exr_choice;
mod exr_facts;
mod exr_file;
mod exr_header;
mod exr_key_code;
pub mod exr_new;
pub mod exr_packing;
pub mod exr_plate;
mod exr_texts;
mod facts;
pub mod flat_plate;
pub mod format;
mod guard;
mod hdr_file;
mod jpeg_file;
pub mod json;
mod limits;
pub mod lut_file;
pub mod manifest;
pub mod matte;
mod other_format;
pub mod picture;
pub mod plate;
mod png_chunks;
mod png_file;
pub mod provenance;
pub mod residual;
pub mod sequence;
mod text_lines;
mod tiff_file;
mod tiff_tags;
mod tiff_write;
mod tile_image;
pub mod windows;

pub use error::{FileError, Result};

#[cfg(test)]
mod tests;
