//! Fourier transforms of real squares.

use crate::LocalKernel;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// Between squares of one side and their spectra, which are column by column, of half as many and one.
pub(super) struct Transform {
    pub(super) side: usize,
    across: Arc<dyn RealToComplex<f32>>,
    back_across: Arc<dyn ComplexToReal<f32>>,
    down: Arc<dyn Fft<f32>>,
    back_down: Arc<dyn Fft<f32>>,
}

/// Buffers of one thread.
#[derive(Default)]
pub(super) struct Space {
    /// Column by column.
    pub(super) spectrum: Vec<Complex<f32>>,
    line: Vec<Complex<f32>>,
    scratch: Vec<Complex<f32>>,
}

impl Transform {
    pub(super) fn new(side: usize) -> Self {
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        Self {
            side,
            across: real.plan_fft_forward(side),
            back_across: real.plan_fft_inverse(side),
            down: complex.plan_fft_forward(side),
            back_down: complex.plan_fft_inverse(side),
        }
    }

    /// Columns of a spectrum of real samples.
    pub(super) fn half(&self) -> usize {
        self.side / 2 + 1
    }

    pub(super) fn of_kernel(&self, kernel: &LocalKernel) -> Vec<Complex<f32>> {
        let mut square = vec![0.0; self.side * self.side];
        let wrap = |at: i32| at.rem_euclid(self.side as i32) as usize;
        for (k, weight) in kernel.weights.iter().enumerate() {
            let (x, y) = ((k % kernel.width) as i32, (k / kernel.width) as i32);
            square[wrap(kernel.top + y) * self.side + wrap(kernel.left + x)] += weight;
        }
        let mut space = Space::default();
        self.forward(&mut square, &mut space);
        space.spectrum
    }

    /// The spectrum of a square into `space`.
    pub(super) fn forward(&self, square: &mut [f32], space: &mut Space) {
        space
            .spectrum
            .resize(self.half() * self.side, Complex::default());
        space.line.resize(self.half(), Complex::default());
        let longest = self
            .across
            .get_scratch_len()
            .max(self.down.get_inplace_scratch_len());
        space.scratch.resize(longest, Complex::default());
        for (y, row) in square.chunks_exact_mut(self.side).enumerate() {
            let scratch = &mut space.scratch[..self.across.get_scratch_len()];
            // Lengths are those that were planned for.
            let _ = self
                .across
                .process_with_scratch(row, &mut space.line, scratch);
            for (x, value) in space.line.iter().enumerate() {
                space.spectrum[x * self.side + y] = *value;
            }
        }
        self.down
            .process_with_scratch(&mut space.spectrum, &mut space.scratch);
    }

    /// The square of the spectrum in `space`.
    pub(super) fn back(&self, space: &mut Space, square: &mut [f32]) {
        let longest = self
            .back_across
            .get_scratch_len()
            .max(self.back_down.get_inplace_scratch_len());
        space
            .scratch
            .resize(longest.max(space.scratch.len()), Complex::default());
        self.back_down
            .process_with_scratch(&mut space.spectrum, &mut space.scratch);
        let scale = 1.0 / (self.side * self.side) as f32;
        for (y, row) in square.chunks_exact_mut(self.side).enumerate() {
            for (x, value) in space.line.iter_mut().enumerate() {
                *value = space.spectrum[x * self.side + y] * scale;
            }
            // What real samples cannot have is rounding.
            space.line[0].im = 0.0;
            space.line[self.half() - 1].im = 0.0;
            let scratch = &mut space.scratch[..self.back_across.get_scratch_len()];
            let _ = self
                .back_across
                .process_with_scratch(&mut space.line, row, scratch);
        }
    }
}
