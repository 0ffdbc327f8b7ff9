//! The optics of Seidel: what a lens does to a point of light.
//!
//! The model is that of Simpkins and Stevenson, "Parameterized modeling of spatially varying optical
//! blur: mathematical theory and models" (2014), with its errata corrected: third-order (Seidel)
//! aberrations of a thick lens with offset pupils give the second and third central moments of the
//! point-spread function (PSF) as polynomials of image position. Equation numbers in this crate ("Eq 25")
//! are those of the paper; `docs/background/model.md` states the mathematics.
//!
//! [`lens`] holds the model, [`effects`] what real lenses do beyond it, [`psf`] the PSF models drawn from
//! moments or rays, [`profile`] a fitted lens as values and JSON, and [`predict`] the blur of a profile at any
//! point of the field.
//!
//! # Frames and units
//! - *Frame pixels*: x right, y down, (0, 0) the outer corner of the top-left pixel.
//! - *Field*: position from the optical axis in half frame widths ([`field::FieldPoint`]).
//! - Moments are central, in pixels to the power of their order.
//! - Distances are metres along the optical axis from the entrance pupil; vergence is 1 / distance.
#![forbid(unsafe_code)]

mod blur_field;
pub mod camera;
pub mod distance;
pub mod effects;
pub mod error;
pub mod field;
pub mod lens;
pub mod moments;
pub mod numeric;
pub mod observations;
pub mod predict;
pub mod profile;
pub mod psf;
pub mod sensor;
pub mod tile;

pub use blur_field::{BlurField, DisplacedBlur, apply_tone};
pub use error::{Error, ErrorKind, Fault, Result};
