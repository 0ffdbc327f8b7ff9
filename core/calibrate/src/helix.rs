//! Two-dimensional convolution by one-dimensional Fourier transforms, in helical layout.
//!
//! Concatenated rows turn a two-dimensional convolution into a one-dimensional one, correct wherever the tile
//! does not cross the end of a row. Frequency f of `length` samples is the plane wave with a phase of 2 pi f
//! / length per pixel and 2 pi f stride / length per row.

use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use seidel_fourier::{Complex, ComplexToReal, Planner, RealToComplex, fast_length};

/// Planned transforms of arrays with rows of `stride` samples.
#[derive(Clone)]
pub(crate) struct Helix {
    /// Samples per row.
    pub(crate) stride: usize,
    /// Length of the transform, slightly more than all rows.
    pub(crate) length: usize,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
}

impl Helix {
    /// Plans transforms of `rows` rows of `stride` samples.
    pub(crate) fn new(stride: usize, rows: usize) -> Self {
        let length = fast_length(stride * rows);
        let mut planner = Planner::<f64>::new();
        Self {
            stride,
            length,
            forward: planner.real_forward(length),
            inverse: planner.real_inverse(length),
        }
    }

    /// Returns the transform of `values`.
    pub(crate) fn spectrum(&self, mut values: Vec<f64>) -> Vec<Complex<f64>> {
        let mut spectrum = self.forward.make_output_vec();
        self.forward
            .process(&mut values, &mut spectrum)
            .expect("buffers were made for this length");
        spectrum
    }

    /// Returns the inverse transform of `spectrum`.
    pub(crate) fn values(&self, mut spectrum: Vec<Complex<f64>>) -> Vec<f64> {
        // The transform of real values is real at these two frequencies, up to rounding.
        let last = spectrum.len() - 1;
        for k in [0, last] {
            spectrum[k].im = 0.0;
        }
        let mut values = self.inverse.make_output_vec();
        self.inverse
            .process(&mut spectrum, &mut values)
            .expect("buffers were made for this length");
        let scale = 1.0 / self.length as f64;
        values.iter_mut().for_each(|v| *v *= scale);
        values
    }

    /// Lays out the rows of `tile`, `width` samples each, zero-padded.
    pub(crate) fn laid_out(&self, tile: &[f64], width: usize) -> Vec<f64> {
        let mut values = vec![0.0; self.length];
        for (row, line) in tile.chunks_exact(width).enumerate() {
            values[row * self.stride..][..width].copy_from_slice(line);
        }
        values
    }

    /// Extracts the square tile of side `side` at the start of `values`.
    pub(crate) fn cut_out(&self, values: &[f64], side: usize) -> Vec<f64> {
        let rows = (0..side).flat_map(|row| &values[row * self.stride..][..side]);
        rows.copied().collect()
    }

    /// Returns the index of a lag of `rows` and `columns`, of either sign.
    pub(crate) fn lag(&self, rows: isize, columns: isize) -> usize {
        let flat = rows * self.stride as isize + columns;
        flat.rem_euclid(self.length as isize) as usize
    }

    /// Returns the squared response of the Laplacian at every frequency.
    pub(crate) fn laplacian_power(&self) -> Vec<f64> {
        (0..=self.length / 2)
            .map(|f| {
                let across = TAU * f as f64 / self.length as f64;
                let down = across * self.stride as f64;
                let response = 4.0 - 2.0 * across.cos() - 2.0 * down.cos();
                response * response
            })
            .collect()
    }

    /// Returns how many of the `length` frequencies each entry of a spectrum stands for: 1 or 2.
    pub(crate) fn multiplicity(&self, f: usize) -> f64 {
        if f == 0 || 2 * f == self.length {
            1.0
        } else {
            2.0
        }
    }
}

impl fmt::Debug for Helix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Helix")
            .field("stride", &self.stride)
            .field("length", &self.length)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_of_spectra_are_plane_convolutions() {
        let (stride, side) = (11, 3);
        let helix = Helix::new(stride, stride);
        let picture: Vec<f64> = (0..stride * stride)
            .map(|k| ((k * k) as f64 * 0.37).sin())
            .collect();
        let tile: Vec<f64> = (0..side * side).map(|k| (k as f64 * 1.3).cos()).collect();
        let a = helix.spectrum(helix.laid_out(&picture, stride));
        let b = helix.spectrum(helix.laid_out(&tile, side));
        let got = helix.values(a.iter().zip(&b).map(|(a, b)| a * b).collect());
        for y in side - 1..stride {
            for x in side - 1..stride {
                let mut want = 0.0;
                for ky in 0..side {
                    for kx in 0..side {
                        want += tile[ky * side + kx] * picture[(y - ky) * stride + x - kx];
                    }
                }
                assert!((got[y * stride + x] - want).abs() < 1e-12, "({x}, {y})");
            }
        }
        assert_eq!(helix.cut_out(&helix.laid_out(&tile, side), side), tile);
        assert_eq!(helix.lag(-1, 2), helix.length - stride + 2);
    }
}
