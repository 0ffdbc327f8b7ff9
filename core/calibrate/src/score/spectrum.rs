//! Two-dimensional Fourier transform of real arrays.

use std::sync::Arc;

use seidel_fourier::{Complex, Planner, RealToComplex};

/// A planned transform of real `width` x `height` arrays.
///
/// Only the half plane of column frequencies 0..=width / 2 is computed; the other half is its conjugate.
/// Columns are transformed as two real sequences, their real and imaginary parts.
pub(crate) struct Transform {
    width: usize,
    height: usize,
    across: Arc<dyn RealToComplex<f64>>,
    down: Arc<dyn RealToComplex<f64>>,
}

impl Transform {
    pub(crate) fn new(width: usize, height: usize) -> Self {
        let mut planner = Planner::<f64>::new();
        Self {
            width,
            height,
            across: planner.real_forward(width),
            down: planner.real_forward(height),
        }
    }

    /// Returns the number of column frequencies, width / 2 + 1.
    pub(crate) fn columns(&self) -> usize {
        self.width / 2 + 1
    }

    /// Returns how many entries of the full plane hold column frequency `kx`: 1 or 2.
    pub(crate) fn multiplicity(&self, kx: usize) -> f64 {
        if kx == 0 || 2 * kx == self.width {
            1.0
        } else {
            2.0
        }
    }

    /// Returns the unnormalised transform of `samples`, rows of `row_length` zero-padded at the right and
    /// bottom. Entry `kx * height + ky` holds column frequency kx and row frequency ky.
    pub(crate) fn apply(&self, samples: &[f64], row_length: usize) -> Vec<Complex<f64>> {
        debug_assert!(row_length <= self.width && samples.len() <= row_length * self.height);
        let mut plane = vec![Complex::default(); self.columns() * self.height];
        let mut row = vec![0.0; self.width];
        let mut line = self.across.make_output_vec();
        let mut scratch = self.across.make_scratch_vec();
        for (y, given) in samples.chunks_exact(row_length).enumerate() {
            row[..row_length].copy_from_slice(given);
            // The transform overwrites its input.
            row[row_length..].fill(0.0);
            self.across
                .process_with_scratch(&mut row, &mut line, &mut scratch)
                .expect("buffers were made for this length");
            for (kx, value) in line.iter().enumerate() {
                plane[kx * self.height + y] = *value;
            }
        }
        let mut part = vec![0.0; self.height];
        let mut real = self.down.make_output_vec();
        let mut imaginary = self.down.make_output_vec();
        let mut scratch = self.down.make_scratch_vec();
        for column in plane.chunks_exact_mut(self.height) {
            for (p, value) in part.iter_mut().zip(column.iter()) {
                *p = value.re;
            }
            self.down
                .process_with_scratch(&mut part, &mut real, &mut scratch)
                .expect("buffers were made for this length");
            for (p, value) in part.iter_mut().zip(column.iter()) {
                *p = value.im;
            }
            self.down
                .process_with_scratch(&mut part, &mut imaginary, &mut scratch)
                .expect("buffers were made for this length");
            // F = R + i I at ky, and conj(R) + i conj(I) at -ky.
            for (ky, (r, i)) in real.iter().zip(&imaginary).enumerate() {
                column[ky] = Complex::new(r.re - i.im, r.im + i.re);
                if ky > 0 {
                    column[self.height - ky] = Complex::new(r.re + i.im, i.re - r.im);
                }
            }
        }
        plane
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_is_the_defining_sum() {
        for (width, height) in [(6, 4), (5, 7), (4, 5)] {
            let transform = Transform::new(width, height);
            let (row_length, rows) = (3, 3);
            let samples: Vec<f64> = (0..9).map(|k| ((k * k) as f64 * 0.7).sin()).collect();
            let got = transform.apply(&samples, row_length);
            for kx in 0..transform.columns() {
                for ky in 0..height {
                    let mut want = Complex::new(0.0, 0.0);
                    for y in 0..rows {
                        for x in 0..row_length {
                            let turns =
                                (kx * x) as f64 / width as f64 + (ky * y) as f64 / height as f64;
                            want += Complex::from_polar(
                                samples[y * row_length + x],
                                -std::f64::consts::TAU * turns,
                            );
                        }
                    }
                    let error = (got[kx * height + ky] - want).norm();
                    assert!(error < 1e-13, "{width} x {height}, ({kx}, {ky}): {error}");
                }
            }
        }
    }
}
