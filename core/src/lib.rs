//! The optics of Seidel: what a lens does to a point of light, learned from measured point-spread
//! functions (PSFs) and put on plates.
//!
//! Everything here works on values: no file, clock, environment or global is touched. Data flow one
//! way: [`observations`] -> [`fit`] -> [`profile`] -> [`psf`] -> [`render`] or [`eval`].
//!
//! The model is that of Simpkins and Stevenson, "Parameterized modeling of spatially varying optical
//! blur: mathematical theory and models" (2014), with its errata mended: third-order (Seidel) rays
//! through a thick lens with offset pupils. Equation numbers in this crate ("Eq 25") are theirs.
//!
//! # Frames and units
//! - *Frame pixels*: x right, y down, (0, 0) the outer corner of the top-left pixel.
//! - *Field*: position from the optical axis in half frame widths ([`field::FieldPoint`]).
//! - Moments are central, in pixels to the power of their order.
//! - Distances are metres along the optical axis from the entrance pupil.
#![forbid(unsafe_code)]

pub mod camera;
pub mod diagnose;
pub mod distance;
pub mod effects;
pub mod error;
pub mod eval;
pub mod field;
pub mod fit;
pub mod lens;
pub mod moments;
pub mod observations;
pub mod plate;
pub mod predict;
pub mod profile;
pub mod psf;
pub mod remove;
pub mod render;
pub mod sensor;
pub mod tile;
pub mod trial;

pub use error::{Error, Fault, Result};
