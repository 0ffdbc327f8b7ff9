//! The files of Seidel: images, PSF observation sets, lens profiles and animation tables.
//!
//! A [`PlateFile`](plate::PlateFile) is read from a file of any [format](formats) as scene-linear planes. Written in its own format, everything
//! else in the file passes through; written in another, the returned warnings name everything that is lost. Each
//! format has a folder that implements the trait `ImageFormat`.
//!
//! Outputs are written completely or not at all ([`atomic`]). Every error names the file, the place, the problem and a
//! remedy ([`FileError`]). Damaged and hostile files are errors: headers are checked before memory is allocated.
//!
//! # Example
//!
//! Write a small EXR file and read it back:
//!
//! ```
//! use seidel_image_io::formats::exr::{NewChannel, write_channels};
//! use seidel_image_io::plate::{PlateFile, PlateOptions};
//! use seidel_image_io::windows::ImageWindows;
//!
//! # fn main() -> seidel_image_io::Result<()> {
//! let folder = tempfile::tempdir().expect("a temporary folder");
//! let path = folder.path().join("grey.exr");
//! let samples = [0.0, 0.25, 0.5, 4.0];
//! let channel = NewChannel {
//!     name: "Y",
//!     samples: &samples,
//!     half: true,
//! };
//! write_channels(&path, ImageWindows::of_size(2, 2), &[channel])?;
//!
//! let plate = PlateFile::open(&path, &PlateOptions::default())?;
//! assert_eq!(plate.colour_names(), ["Y"]);
//! assert_eq!(plate.colour(), [samples]);
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod animation;
pub mod atomic;
pub mod depth_name;
pub mod description;
pub mod edge_set;
pub mod error;
pub mod format;
pub mod formats;
mod guard;
pub mod image_channel;
mod image_file;
mod input;
pub mod json;
pub mod lens_metadata;
pub mod lens_profile;
pub mod lut;
pub mod metadata;
mod new_image;
pub mod observation_set;
mod part;
pub mod partial;
pub mod photograph;
pub mod plate;
pub mod provenance;
pub mod raster;
pub mod residual;
mod rgbe;
pub mod samples;
pub mod sequence;
mod tile_image;
pub mod windows;

pub use error::{FileError, Result};

#[cfg(test)]
mod tests;
