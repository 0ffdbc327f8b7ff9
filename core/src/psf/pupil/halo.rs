//! The light of a halo, integrated over pixels.

use std::f64::consts::PI;

use crate::sensor::Halo;

/// The density of a halo, which holds one over the plane.
pub(super) struct Moffat {
    /// Radius squared, px².
    radius2: f64,
    steepness: f64,
    /// Density in the middle, px^-2.
    peak: f64,
}

impl Moffat {
    pub(super) fn new(halo: &Halo) -> Self {
        let radius2 = halo.radius_px.powi(2).max(1e-6);
        Self {
            radius2,
            steepness: halo.steepness,
            peak: (halo.steepness - 1.0) / (PI * radius2),
        }
    }

    /// The mean density over a square of side `side` at (x, y): that in its middle, and what the Laplacian
    /// adds.
    fn mean(&self, x: f64, y: f64, side: f64) -> f64 {
        let b = self.steepness;
        let r = (x * x + y * y) / self.radius2;
        let density = self.peak * (-b * r.ln_1p()).exp();
        let bend = 4.0 * b / self.radius2 * (b * r - 1.0) / (1.0 + r).powi(2);
        density * (1.0 + side * side / 24.0 * bend)
    }

    /// Light of the pixels from 0 to `count` (x, y) px away, row-major.
    pub(super) fn table(&self, [columns, rows]: [usize; 2]) -> Vec<f64> {
        let mut table = Vec::with_capacity(columns * rows);
        for y in 0..rows {
            for x in 0..columns {
                let (x, y) = (x as f64, y as f64);
                // Parts of a pixel so small that the density hardly bends in one.
                let parts = (6.0 / (self.radius2 + x * x + y * y).sqrt()).ceil();
                let parts = parts.clamp(1.0, 64.0);
                if parts == 1.0 {
                    table.push(self.mean(x, y, 1.0));
                    continue;
                }
                let side = 1.0 / parts;
                let at = |k: usize| (k as f64 + 0.5) * side - 0.5;
                let parts = parts as usize;
                let places = (0..parts * parts).map(|k| (x + at(k % parts), y + at(k / parts)));
                let sum: f64 = places.map(|(x, y)| self.mean(x, y, side)).sum();
                table.push(sum * side * side);
            }
        }
        table
    }
}
