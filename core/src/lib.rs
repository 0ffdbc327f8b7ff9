//! Real lens blur: a lens learned from measured point-spread functions (PSFs), its blur applied to a plate, removed from
//! it, and diagnosed.
//!
//! # The model in one screen
//! A real lens blurs each point differently: by its position in the field, its colour channel and its distance.
//! Third-order (Seidel) aberrations of a thick lens give the central moments of the PSF as polynomials of image position
//! with ten coefficients S1..S10 per channel and distance (Simpkins and Stevenson 2014). [`fit()`] estimates such a lens
//! from PSF tiles, either from their moments or ray by ray with further effects; [`Lens`] predicts the PSF anywhere;
//! [`apply()`] scatters each source pixel x' of a plate I with its own PSF,
//!
//! > O(x) = sum over x' of I(x') P_x'(x - x'),
//!
//! guided by a depth pass, near surfaces occluding far ones. [`remove()`] solves for the I of a given O, [`relens()`]
//! replaces one lens by another, and [`diagnose()`] names the effects that a lens lacks against measured PSFs.
//!
//! ```
//! # fn main() -> seidel_core::Result<()> {
//! # let profile = include_str!("../tests/data/lens.json");
//! # let (width, height, samples, metres) = (60, 40, [0.5; 60 * 40 * 4], vec![2.0; 60 * 40]);
//! use seidel_core::{Depth, DepthPass, Image, Lens, Plate, Settings, apply, no_progress};
//!
//! let lens = Lens::from_json(profile)?;
//! let image = Image::from_interleaved(width, height, 4, &samples)?;
//! let plate = Plate::new(image).with_depth(Depth::Pass(DepthPass::metres(metres)));
//! let blurred = apply(&lens, &plate, &Settings::default(), &no_progress)?;
//! assert_eq!(blurred.to_interleaved().len(), samples.len());
//! # Ok(())
//! # }
//! ```
//!
//! # Frames and units
//! Samples are scene-linear, in separate row-major planes. Frame pixels have x right, y down and (0, 0) at the outer corner
//! of the top-left pixel. Distances are metres along the optical axis from the entrance pupil, vergence is 1 / distance.
//!
//! # Packages
//! The parts are packages of their own, re-exported here: [`optics`] (lens, effects, PSF models, profiles), [`render`]
//! (renderers, occlusion, deconvolution), [`calibrate`] (fit, evaluation, diagnosis).
#![forbid(unsafe_code)]

mod apply;
mod channel_weights;
mod diagnose;
mod image;
mod lens;
mod memory;
mod placement;
mod planes;
mod plate;
mod prepared;
mod prepared_depth;
mod relens;
mod remove;
mod removed;
mod rendering;
mod session;
mod settings;

pub use seidel_calibrate as calibrate;
pub use seidel_optics as optics;
pub use seidel_render as render;

pub use seidel_calibrate::{eval, measure, score};
pub use seidel_optics::{
    camera, distance, effects, error, field, moments, numeric, observations, predict, profile, psf,
    sensor, tile,
};

pub use apply::apply;
pub use diagnose::diagnose;
pub use image::{AlphaKind, Image};
pub use lens::Lens;
pub use memory::{apply_bytes, remove_bytes};
pub use placement::{PlatePlacement, Rectangle};
pub use plate::{Depth, DepthMeaning, DepthPass, HoldoutMatte, Plate, PlateGeometry};
pub use prepared::PreparedPlate;
pub use prepared_depth::{PreparedDepth, PreparedHoldout};
pub use relens::relens;
pub use remove::remove;
pub use removed::{NoiseGain, RemovedPlate};
pub use rendering::Rendering;
pub use seidel_calibrate::diagnose::{Diagnosis, Settings as DiagnosisSettings, Verdict};
pub use seidel_calibrate::fit::{Fit, FitSettings, Model, fit};
pub use seidel_optics::distance::ObjectDistance;
pub use seidel_optics::error::{Error, ErrorKind, Fault, Result};
pub use seidel_optics::field::ImagePoint;
pub use seidel_optics::observations::ObservationSet;
pub use seidel_optics::profile::{Controls, LensProfile};
pub use seidel_optics::{Progress, no_progress};
pub use seidel_render::remove::Saturation;
pub use seidel_render::{DepthConvention, Displacement, FocusControls};
pub use session::LensSession;
pub use settings::{
    ChannelScale, Edges, Grain, OcclusionSettings, Quality, RemovalSettings, Settings,
};

/// The Rust code of the README, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
