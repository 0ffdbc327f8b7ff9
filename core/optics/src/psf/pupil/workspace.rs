//! Buffers and results of drawing a pupil.

use super::fourier::Fourier;
use super::mesh::{self, Ring};
use super::rasterise::Canvas;

/// Reusable buffers of [`draw`](super::draw).
#[derive(Debug, Default)]
pub struct Workspace {
    pub(super) inner: Ring,
    pub(super) outer: Ring,
    pub(super) canvas: Canvas,
    pub(super) fourier: Fourier,
}

/// A PSF drawn by [`draw`](super::draw) and its derivatives, row-major.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PsfImage {
    /// Share of the light in each pixel.
    pub light: Vec<f64>,
    /// Derivatives of `light`, [`PsfImage::stride`] values a pixel: one for each parameter, then padding.
    pub derivatives: Vec<f64>,
    /// Derivative of `light` by the variance of the symmetric blur, per px².
    pub blur_derivative: Vec<f64>,
}

impl PsfImage {
    /// Returns the number of values a pixel in [`PsfImage::derivatives`] for that many `derivatives`.
    pub fn stride(derivatives: usize) -> usize {
        mesh::packs(derivatives) * mesh::LANES
    }
}
