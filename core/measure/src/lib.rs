//! Measurement of point-spread functions (PSFs) in photographs.
//!
//! [`measure_lights`] finds point lights (pinholes, LEDs, stars) in one or more photographs and cuts a tile around each
//! one. Photographs of a sensor with a colour filter mosaic are never interpolated: a tile holds raw pixels, and the pixels
//! of a channel are those of its colour. [`LightSet::observations`] makes a [`seidel_optics::observations::ObservationSet`]
//! of the result, to which a lens is fitted. [`measure_edges`] finds straight edges and measures their profiles.
//!
//! | module | holds |
//! | --- | --- |
//! | [`photograph`] | a photograph in counts above black, with its mosaic and clipping level |
//! | [`calibration`] | dark and flat frames: subtraction, division, bad pixels, dust |
//! | [`background`] | background and its noise, by channel on a mesh |
//! | [`hot_pixels`] | defective pixels, found by their neighbours and repaired for the detection |
//! | [`detection`] | matched filter over all channels, its peaks, and their extent |
//! | [`profile_fit`] | Gauss-Hermite fit: centroid, flux and moments of a light in one channel |
//! | [`photon_transfer`] | counts per electron from the residuals of many lights |
//! | [`smooth_field`] | robust polynomial over the field, from which outliers depart |
//! | [`rejection`] | lights that were left out, with the reason |
//! | [`checks`] | faults of a photograph: processing, mosaic, black level |
//! | [`lights`] | the steps together |
//! | [`edges`] | straight edges: segments, lines, profiles and their moments |
//! | [`printed`] | charts to print: noise, edges, board, lights |
//! | [`capture_plan`] | what to photograph: distances, sizes, exposures |
//!
//! Counts are linear in light. Frame pixels have x right, y down and (0, 0) at the outer corner of the top-left pixel.
#![forbid(unsafe_code)]

pub mod background;
pub mod calibration;
pub mod capture_plan;
pub mod chart;
pub mod checks;
pub mod detection;
pub mod edges;
pub mod hot_pixels;
pub mod lights;
pub mod photograph;
pub mod photon_transfer;
pub mod printed;
pub mod profile_fit;
pub mod rejection;
mod robust_fit;
pub mod smooth_field;

pub use calibration::Calibration;
pub use checks::{Concern, Severity};
pub use edges::{EdgeSettings, MeasuredEdges, measure_edges};
pub use lights::{LightSet, LightSettings, MeasuredLight, TileSize, measure_lights};
pub use photograph::{Photograph, SampleErrors};
pub use rejection::{LeftOut, Reason};

#[cfg(test)]
mod tests;
