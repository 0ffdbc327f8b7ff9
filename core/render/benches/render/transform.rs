//! Real Fourier transforms in two dimensions, for the overlap-add renderer.

use seidel_fourier::{Complex, ComplexToReal, Fft, RealToComplex};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Rows transposed together.
const BLOCK: usize = 16;

/// Returns the smallest even 2^a 3^b 5^c that is at least `size`.
pub(crate) fn good_size(size: usize) -> usize {
    let smooth = |mut n: usize| {
        for prime in [2, 3, 5] {
            while n.is_multiple_of(prime) {
                n /= prime;
            }
        }
        n == 1
    };
    let mut found = size.max(2).next_multiple_of(2);
    while !smooth(found) {
        found += 2;
    }
    found
}

/// Transforms of one size. Spectra are stored column by column.
pub(crate) struct Transform {
    pub(crate) width: usize,
    pub(crate) height: usize,
    across: Arc<dyn RealToComplex<f32>>,
    back_across: Arc<dyn ComplexToReal<f32>>,
    down: Arc<dyn Fft<f32>>,
    back_down: Arc<dyn Fft<f32>>,
}

/// Transforms by size (columns, rows), planned once.
#[derive(Default)]
pub(crate) struct Planner {
    known: BTreeMap<(usize, usize), Arc<Transform>>,
}

impl Planner {
    /// Returns the transform of `size`, columns and rows.
    pub(crate) fn transform(&mut self, size: (usize, usize)) -> Arc<Transform> {
        let (width, height) = size;
        let plan = || {
            let mut plans = seidel_fourier::Planner::<f32>::new();
            Arc::new(Transform {
                width,
                height,
                across: plans.real_forward(width),
                back_across: plans.real_inverse(width),
                down: plans.forward(height),
                back_down: plans.inverse(height),
            })
        };
        self.known.entry(size).or_insert_with(plan).clone()
    }
}

/// Buffers of one thread.
#[derive(Default)]
pub(crate) struct Space {
    line: Vec<f32>,
    block: Vec<Complex<f32>>,
    scratch: Vec<Complex<f32>>,
}

impl Transform {
    /// Columns of a spectrum.
    fn columns(&self) -> usize {
        self.width / 2 + 1
    }

    /// The spectrum, into `out`, of a picture whose first `rows` rows are written by `row`; the rest is
    /// zero, as is what `row` leaves alone.
    pub(crate) fn forward(
        &self,
        rows: usize,
        row: impl Fn(usize, &mut [f32]),
        space: &mut Space,
        out: &mut Vec<Complex<f32>>,
    ) {
        let columns = self.columns();
        out.clear();
        out.resize(columns * self.height, Complex::default());
        space.block.resize(BLOCK * columns, Complex::default());
        let longest = self.across.get_scratch_len();
        let longest = longest.max(self.down.get_inplace_scratch_len());
        space.scratch.resize(longest, Complex::default());
        for first in (0..rows).step_by(BLOCK) {
            let count = BLOCK.min(rows - first);
            for (k, spectrum) in space
                .block
                .chunks_exact_mut(columns)
                .take(count)
                .enumerate()
            {
                space.line.clear();
                space.line.resize(self.width, 0.0);
                row(first + k, &mut space.line);
                let scratch = &mut space.scratch[..self.across.get_scratch_len()];
                self.across
                    .process_with_scratch(&mut space.line, spectrum, scratch)
                    .expect("buffers of the planned size");
            }
            for (x, column) in out.chunks_exact_mut(self.height).enumerate() {
                for (k, value) in column[first..first + count].iter_mut().enumerate() {
                    *value = space.block[k * columns + x];
                }
            }
        }
        self.down.process_with_scratch(out, &mut space.scratch);
    }

    /// The first `size` (columns, rows) samples of the picture of `spectrum`, which is used up.
    pub(crate) fn back(
        &self,
        spectrum: &mut [Complex<f32>],
        size: (usize, usize),
        space: &mut Space,
    ) -> Vec<f32> {
        let columns = self.columns();
        let longest = self.back_across.get_scratch_len();
        let longest = longest.max(self.back_down.get_inplace_scratch_len());
        space.scratch.resize(longest, Complex::default());
        self.back_down
            .process_with_scratch(spectrum, &mut space.scratch);
        space.block.resize(BLOCK * columns, Complex::default());
        space.line.resize(self.width, 0.0);
        let mut out = Vec::with_capacity(size.0 * size.1);
        for first in (0..size.1).step_by(BLOCK) {
            let count = BLOCK.min(size.1 - first);
            for (x, column) in spectrum.chunks_exact(self.height).enumerate() {
                for (k, value) in column[first..first + count].iter().enumerate() {
                    space.block[k * columns + x] = *value;
                }
            }
            for line in space.block.chunks_exact_mut(columns).take(count) {
                // What rounding left where a real picture has nothing.
                line[0].im = 0.0;
                line[columns - 1].im = 0.0;
                let scratch = &mut space.scratch[..self.back_across.get_scratch_len()];
                self.back_across
                    .process_with_scratch(line, &mut space.line, scratch)
                    .expect("buffers of the planned size");
                out.extend_from_slice(&space.line[..size.0]);
            }
        }
        out
    }
}
