//! Two-dimensional fast Fourier transforms of square tiles of real samples.

use crate::LocalKernel;
use seidel_fourier::{Complex, ComplexToReal, Fft, Planner, RealToComplex};
use std::sync::Arc;

/// The transform of tiles of one side.
///
/// A spectrum is stored column by column. It has `side / 2 + 1` columns, since that of real samples is Hermitian.
pub(super) struct TileFft {
    pub(super) side: usize,
    rows: Arc<dyn RealToComplex<f32>>,
    inverse_rows: Arc<dyn ComplexToReal<f32>>,
    columns: Arc<dyn Fft<f32>>,
    inverse_columns: Arc<dyn Fft<f32>>,
}

/// Buffers of one thread.
#[derive(Default)]
pub(super) struct FftBuffers {
    /// The spectrum, column by column.
    pub(super) spectrum: Vec<Complex<f32>>,
    line: Vec<Complex<f32>>,
    scratch: Vec<Complex<f32>>,
}

impl TileFft {
    pub(super) fn new(side: usize) -> Self {
        let mut planner = Planner::<f32>::new();
        Self {
            side,
            rows: planner.real_forward(side),
            inverse_rows: planner.real_inverse(side),
            columns: planner.forward(side),
            inverse_columns: planner.inverse(side),
        }
    }

    /// Returns the number of columns of a spectrum.
    pub(super) fn column_count(&self) -> usize {
        self.side / 2 + 1
    }

    /// Returns the spectrum of `kernel` around the origin: its transfer function, on a plane of `size` px.
    ///
    /// What the kernel throws further than the plane is wide or high is left out: it reaches no pixel.
    pub(super) fn transfer_function(
        &self,
        kernel: &LocalKernel,
        size: (usize, usize),
    ) -> Vec<Complex<f32>> {
        let mut tile = vec![0.0; self.side * self.side];
        let reaches = |offset: i32, side: usize| (offset.unsigned_abs() as usize) < side;
        let wrap = |at: i32| at.rem_euclid(self.side as i32) as usize;
        for (k, weight) in kernel.weights.iter().enumerate() {
            let x = kernel.left + (k % kernel.width) as i32;
            let y = kernel.top + (k / kernel.width) as i32;
            if reaches(x, size.0) && reaches(y, size.1) {
                tile[wrap(y) * self.side + wrap(x)] += weight;
            }
        }
        let mut buffers = FftBuffers::default();
        self.forward(&mut tile, &mut buffers);
        buffers.spectrum
    }

    /// Writes the spectrum of `tile` to `buffers`, and uses `tile` as scratch space.
    pub(super) fn forward(&self, tile: &mut [f32], buffers: &mut FftBuffers) {
        let columns = self.column_count();
        buffers
            .spectrum
            .resize(columns * self.side, Complex::default());
        buffers.line.resize(columns, Complex::default());
        let row_scratch = self.rows.get_scratch_len();
        let longest = row_scratch.max(self.columns.get_inplace_scratch_len());
        buffers.scratch.resize(longest, Complex::default());
        for (y, row) in tile.chunks_exact_mut(self.side).enumerate() {
            let scratch = &mut buffers.scratch[..row_scratch];
            // The only error is a buffer of another length than planned.
            let _ = self
                .rows
                .process_with_scratch(row, &mut buffers.line, scratch);
            for (x, value) in buffers.line.iter().enumerate() {
                buffers.spectrum[x * self.side + y] = *value;
            }
        }
        self.columns
            .process_with_scratch(&mut buffers.spectrum, &mut buffers.scratch);
    }

    /// Writes the inverse transform of the spectrum in `buffers` to `tile`.
    pub(super) fn inverse(&self, buffers: &mut FftBuffers, tile: &mut [f32]) {
        let row_scratch = self.inverse_rows.get_scratch_len();
        let longest = row_scratch.max(self.inverse_columns.get_inplace_scratch_len());
        buffers
            .scratch
            .resize(longest.max(buffers.scratch.len()), Complex::default());
        buffers.line.resize(self.column_count(), Complex::default());
        self.inverse_columns
            .process_with_scratch(&mut buffers.spectrum, &mut buffers.scratch);
        let scale = 1.0 / (self.side * self.side) as f32;
        for (y, row) in tile.chunks_exact_mut(self.side).enumerate() {
            for (x, value) in buffers.line.iter_mut().enumerate() {
                *value = buffers.spectrum[x * self.side + y] * scale;
            }
            // Real rows have real values at frequency zero and at Nyquist: an imaginary part there is rounding.
            buffers.line[0].im = 0.0;
            buffers.line[self.column_count() - 1].im = 0.0;
            let scratch = &mut buffers.scratch[..row_scratch];
            // The only error is a buffer of another length than planned.
            let _ = self
                .inverse_rows
                .process_with_scratch(&mut buffers.line, row, scratch);
        }
    }
}
