//! Two-dimensional Fourier transforms of real images, with cached plans.
//!
//! A spectrum holds the half plane of frequencies 0..=columns / 2 along x, as lines of all frequencies along y. The
//! other half is its complex conjugate.

use std::fmt;
use std::sync::Arc;

use seidel_fourier::{Complex, ComplexToReal, Fft, Planner, RealToComplex};

/// A value of a spectrum.
pub(super) type C = Complex<f64>;

/// Cached transform plans and reusable buffers.
#[derive(Default)]
pub(super) struct Fourier {
    planner: Option<Box<Planner<f64>>>,
    spare: Vec<Vec<C>>,
}

impl fmt::Debug for Fourier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Fourier")
    }
}

impl Fourier {
    fn planner(&mut self) -> &mut Planner<f64> {
        self.planner
            .get_or_insert_with(|| Box::new(Planner::<f64>::new()))
    }

    /// Returns a buffer of `length` zeros.
    pub(super) fn buffer(&mut self, length: usize) -> Vec<C> {
        let mut buffer = self.spare.pop().unwrap_or_default();
        buffer.clear();
        buffer.resize(length, C::default());
        buffer
    }

    /// Takes a buffer back for reuse by [`Fourier::buffer`].
    pub(super) fn keep(&mut self, buffer: Vec<C>) {
        self.spare.push(buffer);
    }

    /// Returns the forward transform of `length` complex values.
    pub(super) fn line(&mut self, length: usize) -> Arc<dyn Fft<f64>> {
        self.planner().forward(length)
    }

    /// Returns the transforms of real images of `columns` x `rows`.
    pub(super) fn grid(&mut self, [columns, rows]: [usize; 2]) -> Grid {
        let planner = self.planner();
        Grid {
            columns,
            rows,
            across: planner.real_forward(columns),
            across_back: planner.real_inverse(columns),
            down: planner.forward(rows),
            down_back: planner.inverse(rows),
        }
    }
}

/// Forward and inverse transforms of real images of one size.
#[derive(Clone)]
pub(super) struct Grid {
    pub(super) columns: usize,
    pub(super) rows: usize,
    across: Arc<dyn RealToComplex<f64>>,
    across_back: Arc<dyn ComplexToReal<f64>>,
    down: Arc<dyn Fft<f64>>,
    down_back: Arc<dyn Fft<f64>>,
}

impl Grid {
    /// Returns the number of frequencies along x that a spectrum holds.
    pub(super) fn half(&self) -> usize {
        self.columns / 2 + 1
    }

    /// Returns the unnormalised spectrum of `picture` (row-major), for the first `kept` frequencies along x.
    ///
    /// Overwrites `picture` and `lines`.
    pub(super) fn forward(&self, picture: &mut [f64], kept: usize, lines: &mut Vec<C>) -> Vec<C> {
        let kept = kept.min(self.half());
        let mut line = vec![C::default(); self.half()];
        lines.clear();
        lines.resize(self.rows * kept, C::default());
        let mut scratch = self.across.make_scratch_vec();
        let rows = picture.chunks_exact_mut(self.columns);
        for (row, to) in rows.zip(lines.chunks_exact_mut(kept)) {
            self.across
                .process_with_scratch(row, &mut line, &mut scratch)
                .expect("buffers were made for this length");
            to.copy_from_slice(&line[..kept]);
        }
        let mut spectrum = vec![C::default(); self.rows * kept];
        transpose(lines, kept, self.rows, &mut spectrum, self.rows);
        let mut scratch = vec![C::default(); self.down.get_inplace_scratch_len()];
        self.down.process_with_scratch(&mut spectrum, &mut scratch);
        spectrum
    }

    /// Returns the image (row-major) of a whole `spectrum`, scaled by columns x rows. Overwrites `spectrum`.
    pub(super) fn inverse(&self, spectrum: &mut [C]) -> Vec<f64> {
        let half = self.half();
        let mut scratch = vec![C::default(); self.down_back.get_inplace_scratch_len()];
        self.down_back.process_with_scratch(spectrum, &mut scratch);
        let mut lines = vec![C::default(); spectrum.len()];
        transpose(spectrum, self.rows, half, &mut lines, half);
        let mut picture = vec![0.0; self.columns * self.rows];
        let mut scratch = self.across_back.make_scratch_vec();
        let rows = picture.chunks_exact_mut(self.columns);
        for (line, row) in lines.chunks_exact_mut(half).zip(rows) {
            // Real up to rounding; the transform requires exact zeros.
            line[0].im = 0.0;
            if self.columns.is_multiple_of(2) {
                line[half - 1].im = 0.0;
            }
            self.across_back
                .process_with_scratch(line, row, &mut scratch)
                .expect("buffers were made for this length");
        }
        picture
    }
}

/// Transposes `from`, `rows` x `columns`, into `to`, whose lines are `stride` long.
pub(super) fn transpose(from: &[C], columns: usize, rows: usize, to: &mut [C], stride: usize) {
    const BLOCK: usize = 16;
    for first in (0..rows).step_by(BLOCK) {
        for start in (0..columns).step_by(BLOCK) {
            for row in first..(first + BLOCK).min(rows) {
                for column in start..(start + BLOCK).min(columns) {
                    to[column * stride + row] = from[row * columns + column];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_recovers_the_image() {
        for size in [[10, 7], [9, 12], [36, 30]] {
            let grid = Fourier::default().grid(size);
            let picture: Vec<f64> = (0..size[0] * size[1])
                .map(|k| (k * k % 17) as f64)
                .collect();
            let mut spectrum = grid.forward(&mut picture.clone(), grid.half(), &mut Vec::new());
            let sum: f64 = picture.iter().sum();
            assert!((spectrum[0].re - sum).abs() < 1e-9 * sum);
            let back = grid.inverse(&mut spectrum);
            for (a, b) in back.iter().zip(&picture) {
                assert!((a / picture.len() as f64 - b).abs() < 1e-12 * sum);
            }
        }
    }
}
