//! The Moffat profile of a halo, integrated over pixels.

use std::f64::consts::PI;

use crate::sensor::Halo;

/// The density of a halo; it integrates to one over the plane.
pub(super) struct Moffat {
    /// Radius squared, px².
    radius2: f64,
    steepness: f64,
    /// Density at the centre, px^-2.
    peak: f64,
    /// Stretch along x.
    stretch_x: f64,
}

impl Moffat {
    pub(super) fn new(halo: &Halo) -> Self {
        let radius2 = halo.radius_px.powi(2).max(1e-6);
        Self {
            radius2,
            steepness: halo.steepness,
            peak: (halo.steepness - 1.0) / (PI * radius2 * halo.stretch_x),
            stretch_x: halo.stretch_x,
        }
    }

    /// Returns the mean density over a rectangle with these sides (x, y) about (`x`, `y`). Lengths along x are divided by the
    /// stretch.
    ///
    /// The mean of the Taylor series of f to second order is f + (across² f_xx + down² f_yy) / 24. For
    /// f = peak (1 + r)^-b with r = (x² + y²) / R², f_xx = f 2 b / R² (2 (b + 1) x² / R² - (1 + r)) / (1 + r)².
    fn mean(&self, x: f64, y: f64, [across, down]: [f64; 2]) -> f64 {
        let b = self.steepness;
        let r = (x * x + y * y) / self.radius2;
        let density = self.peak * (-b * r.ln_1p()).exp();
        if self.stretch_x == 1.0 {
            // The sides are equal: only the sum f_xx + f_yy matters.
            let laplacian = 4.0 * b / self.radius2 * (b * r - 1.0) / (1.0 + r).powi(2);
            return density * (1.0 + down * down / 24.0 * laplacian);
        }
        let second_derivative = |at: f64| {
            let along = 2.0 * (b + 1.0) * at * at / self.radius2;
            2.0 * b / self.radius2 * (along - (1.0 + r)) / (1.0 + r).powi(2)
        };
        let terms = across * across * second_derivative(x) + down * down * second_derivative(y);
        density * (1.0 + terms / 24.0)
    }

    /// Returns the light of the pixels from 0 up to `columns` and `rows` px away, row-major.
    pub(super) fn table(&self, [columns, rows]: [usize; 2]) -> Vec<f64> {
        let mut table = Vec::with_capacity(columns * rows);
        // Sides of a pixel; that along x is divided by the stretch.
        let pixel = [1.0 / self.stretch_x, 1.0];
        for y in 0..rows {
            for x in 0..columns {
                let (x, y) = (x as f64 / self.stretch_x, y as f64);
                // Subdivides the pixel until the density is nearly quadratic in each part.
                let far = (self.radius2 + x * x + y * y).sqrt();
                let parts = pixel.map(|side| (6.0 * side / far).ceil().clamp(1.0, 64.0));
                if parts == [1.0; 2] {
                    table.push(self.mean(x, y, pixel));
                    continue;
                }
                let sides = [pixel[0] / parts[0], pixel[1] / parts[1]];
                let at = |k: usize, axis: usize| (k as f64 + 0.5) * sides[axis] - 0.5 * pixel[axis];
                let [across, down] = parts.map(|count| count as usize);
                let places =
                    (0..across * down).map(|k| (x + at(k % across, 0), y + at(k / across, 1)));
                let sum: f64 = places.map(|(x, y)| self.mean(x, y, sides)).sum();
                table.push(sum * sides[0] * self.stretch_x * sides[1]);
            }
        }
        table
    }
}
