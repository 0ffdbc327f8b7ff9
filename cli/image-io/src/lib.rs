//! The files of Seidel: images, PSF observation sets, lens profiles and animation tables.
//!
//! # Formats
//!
//! | format | samples | stores beside colour and alpha |
//! | --- | --- | --- |
//! | OpenEXR | half, float | all parts, channels and attributes; data window; pixel aspect |
//! | DPX | 8, 10, 12, 16 bit | header and user data; pixel aspect |
//! | PNG | 8, 16 bit | ancillary chunks, texts, ICC profile |
//! | TIFF | 8, 16 bit, half, float | tags, EXIF, ICC profile |
//! | Radiance HDR | RGBE | header lines |
//! | JPEG | 8 bit | read only |
//!
//! A [`Plate`](plate::Plate) is read from any of them as scene-linear planes. Written in its own format, everything
//! else in the file passes through; written in another, the returned warnings name everything that is lost. Each
//! format has a folder that implements the trait `ImageFormat` (see [`mod@format`]).
//!
//! Outputs are written completely or not at all ([`atomic`]). Every error names the file, the place, the problem and a
//! remedy ([`FileError`]). Damaged and hostile files are errors: headers are checked before memory is allocated.
//!
//! # Example
//!
//! Write a small EXR file and read it back:
//!
//! ```
//! use seidel_image_io::exr::{NewChannel, write_channels};
//! use seidel_image_io::plate::{Plate, PlateOptions};
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
//! let plate = Plate::open(&path, &PlateOptions::default())?;
//! assert_eq!(plate.colour_names(), ["Y"]);
//! assert_eq!(plate.colour(), [samples]);
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod animation;
pub mod atomic;
pub mod description;
mod dpx;
pub mod edge_set;
pub mod error;
pub mod exr;
pub mod format;
mod guard;
mod hdr;
pub mod image_channel;
mod input;
mod jpeg;
pub mod json;
pub mod lens_profile;
pub mod lut;
pub mod metadata;
pub mod observation_set;
pub mod partial;
pub mod photograph;
pub mod plate;
pub mod png;
pub mod process_status;
pub mod processor_time;
pub mod provenance;
pub mod raster;
pub mod residual;
pub mod samples;
pub mod sequence;
mod tiff;
mod tile_image;
pub mod windows;

pub use error::{FileError, Result};

#[cfg(test)]
mod tests;
