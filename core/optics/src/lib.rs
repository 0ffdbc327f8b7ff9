//! The optics of Seidel: the point-spread function (PSF) of a lens at any point of the field and any depth.
//!
//! The model is that of Simpkins and Stevenson, "Parameterized modeling of spatially varying optical blur: mathematical
//! theory and models" (2014), with errata corrected. Third-order (Seidel) aberrations of a thick lens with offset pupils
//! give the second and third central moments of the PSF as polynomials of image position. Equation numbers ("Eq 25") are
//! those of the paper; `docs/background/model.md` states the mathematics.
//!
//! | module | contents |
//! | --- | --- |
//! | [`lens`] | the lens model: thick lens, aberrations, moments over the field, wavefront and pupil |
//! | [`effects`] | real lenses beyond third order: vignetting, decentring, diffraction, glare and more |
//! | [`sensor`] | blur and tone curve of the sensor |
//! | [`psf`] | PSF models, kernels and sampling |
//! | [`profile`] | fitted lenses as values and as JSON |
//! | [`library`] | designed lenses that come with the program |
//! | [`predict`] | the blur of a profile at any point; predicted observation sets |
//! | [`observations`], [`tile`], [`mosaic`], [`camera`] | measured PSFs |
//! | [`moments`] | central moments, and their measurement from tiles |
//!
//! # Frames and units
//! - *Frame pixels*: x right, y down, (0, 0) at the outer corner of the top-left pixel.
//! - *Field*: position from the optical axis in half frame widths ([`field::FieldPoint`]).
//! - Moments are central, in pixels to the power of their order.
//! - Distances are metres along the optical axis from the entrance pupil; vergence is 1 / distance.
#![forbid(unsafe_code)]

mod blur_field;
pub mod camera;
pub mod distance;
pub mod edges;
pub mod effects;
pub mod error;
pub mod field;
pub mod lens;
pub mod library;
pub mod moments;
pub mod mosaic;
pub mod numeric;
pub mod observations;
pub mod plane_of_focus;
pub mod predict;
pub mod profile;
mod progress;
pub mod psf;
mod rectangle;
pub mod sensor;
mod sharpest_plane;
pub mod tile;

pub use blur_field::{BlurField, DisplacedBlur, apply_tone};
pub use error::{Error, ErrorKind, Fault, Result};
pub use progress::{Progress, no_progress};
pub use rectangle::Rectangle;
pub use sharpest_plane::sharpest_vergence;
