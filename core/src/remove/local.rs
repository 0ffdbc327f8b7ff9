//! Filters made of a lens's local spectra: a plate is cut into overlapping squares, each is filtered as if the
//! lens's blur were that of its middle all over, and they are put together under smooth windows.

use super::prior::response;
use crate::error::Result;
use crate::render::{LocalKernel, Scene, kernel_at};
use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::PI;
use std::sync::Arc;

/// Side of a square; neighbours lie half of it apart.
const SIDE: usize = 128;
const HOP: usize = SIDE / 2;
/// Columns of a spectrum of real samples.
const HALF: usize = SIDE / 2 + 1;

/// The local spectra of a lens over a plate.
pub(super) struct Local {
    size: (usize, usize),
    /// First column and row of each square.
    squares: Vec<(i32, i32)>,
    /// The transfer function of each square, column by column.
    spectra: Vec<Vec<Complex<f32>>>,
    /// |D|^2 of the differences that the prior looks at, column by column.
    pub(super) slopes: Vec<f32>,
    transform: Transform,
    /// Square root of a Hann window along one axis.
    window: Vec<f32>,
}

struct Transform {
    across: Arc<dyn RealToComplex<f32>>,
    back_across: Arc<dyn ComplexToReal<f32>>,
    down: Arc<dyn Fft<f32>>,
    back_down: Arc<dyn Fft<f32>>,
}

impl Local {
    /// Of a scene at one vergence, for a plane of some channel weights.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn new(scene: &Scene, weights: &[f64], vergence: f64) -> Result<Self> {
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        let transform = Transform {
            across: real.plan_fft_forward(SIDE),
            back_across: real.plan_fft_inverse(SIDE),
            down: complex.plan_fft_forward(SIDE),
            back_down: complex.plan_fft_inverse(SIDE),
        };
        let size = (scene.width, scene.height);
        let starts = |size: usize| (0..size.div_ceil(HOP) as i32 + 1).map(|k| (k - 1) * HOP as i32);
        let squares: Vec<(i32, i32)> = starts(size.1)
            .flat_map(|y| starts(size.0).map(move |x| (x, y)))
            .collect();
        let middle =
            |start: i32, size: usize| (f64::from(start) + HOP as f64).clamp(0.0, size as f64);
        let spectra = squares
            .par_iter()
            .map(|(x, y)| {
                let at = (middle(*x, size.0), middle(*y, size.1));
                let kernel = kernel_at(scene, weights, at, vergence)?;
                Ok(transform.of_kernel(&kernel))
            })
            .collect::<Result<_>>()?;
        let wave = |k: usize| k as f64 / SIDE as f64;
        Ok(Self {
            size,
            squares,
            spectra,
            slopes: (0..HALF)
                .flat_map(|x| (0..SIDE).map(move |y| response(wave(x), wave(y)) as f32))
                .collect(),
            transform,
            window: (0..SIDE)
                .map(|k| (PI * (k as f64 + 0.5) / SIDE as f64).sin() as f32)
                .collect(),
        })
    }

    /// `plane`, mirrored beyond its edges, with every square filtered by what `filter` makes of its transfer
    /// function and of |D|^2. What it gives beyond them is left out or `folded` back: then this is symmetric
    /// where `filter` is real.
    pub(super) fn filtered(
        &self,
        plane: &[f32],
        folded: bool,
        filter: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        let parts: Vec<Vec<f32>> = self
            .squares
            .par_iter()
            .zip(&self.spectra)
            .map_init(Space::default, |space, (place, spectrum)| {
                let mut square = self.cut(plane, *place);
                self.transform.forward(&mut square, space);
                for ((value, h), slope) in space.spectrum.iter_mut().zip(spectrum).zip(&self.slopes)
                {
                    *value *= filter(*h, *slope);
                }
                self.transform.back(space, &mut square);
                square
            })
            .collect();
        let mut out = vec![0.0; plane.len()];
        // In order, so that sums do not depend on threads.
        for (place, part) in self.squares.iter().zip(&parts) {
            self.add(part, *place, folded, &mut out);
        }
        out
    }

    /// The windowed square at `place`.
    fn cut(&self, plane: &[f32], (left, top): (i32, i32)) -> Vec<f32> {
        let (width, height) = self.size;
        let fold = |at: i32, size: usize| {
            let at = at.rem_euclid(2 * size as i32) as usize;
            at.min(2 * size - 1 - at)
        };
        let columns: Vec<usize> = (0..SIDE as i32).map(|x| fold(left + x, width)).collect();
        let mut square = Vec::with_capacity(SIDE * SIDE);
        for (y, wy) in (0..SIDE as i32).zip(&self.window) {
            let row = &plane[fold(top + y, height) * width..][..width];
            let samples = columns.iter().zip(&self.window);
            square.extend(samples.map(|(x, wx)| wy * wx * row[*x]));
        }
        square
    }

    /// Adds a windowed square; what lies beyond the plate is left out, or where it is `folded`, mirrored back: the
    /// other way round than cutting it out.
    fn add(&self, square: &[f32], (left, top): (i32, i32), folded: bool, out: &mut [f32]) {
        let (width, height) = self.size;
        let fold = |at: i32, size: usize| {
            let inside = (0..size as i32).contains(&at);
            let at = at.rem_euclid(2 * size as i32) as usize;
            (inside || folded).then(|| at.min(2 * size - 1 - at))
        };
        for (y, wy) in (0..SIDE as i32).zip(&self.window) {
            let Some(row) = fold(top + y, height) else {
                continue;
            };
            for (x, wx) in (0..SIDE as i32).zip(&self.window) {
                if let Some(column) = fold(left + x, width) {
                    out[row * width + column] += wy * wx * square[y as usize * SIDE + x as usize];
                }
            }
        }
    }
}

/// Buffers of one thread.
#[derive(Default)]
struct Space {
    /// Column by column.
    spectrum: Vec<Complex<f32>>,
    line: Vec<Complex<f32>>,
    scratch: Vec<Complex<f32>>,
}

impl Transform {
    fn of_kernel(&self, kernel: &LocalKernel) -> Vec<Complex<f32>> {
        let mut square = vec![0.0; SIDE * SIDE];
        let wrap = |at: i32| at.rem_euclid(SIDE as i32) as usize;
        for (k, weight) in kernel.weights.iter().enumerate() {
            let (x, y) = ((k % kernel.width) as i32, (k / kernel.width) as i32);
            square[wrap(kernel.top + y) * SIDE + wrap(kernel.left + x)] += weight;
        }
        let mut space = Space::default();
        self.forward(&mut square, &mut space);
        space.spectrum
    }

    fn forward(&self, square: &mut [f32], space: &mut Space) {
        space.spectrum.resize(HALF * SIDE, Complex::default());
        space.line.resize(HALF, Complex::default());
        let longest = self
            .across
            .get_scratch_len()
            .max(self.down.get_inplace_scratch_len());
        space.scratch.resize(longest, Complex::default());
        for (y, row) in square.chunks_exact_mut(SIDE).enumerate() {
            let scratch = &mut space.scratch[..self.across.get_scratch_len()];
            // Lengths are those that were planned for.
            let _ = self
                .across
                .process_with_scratch(row, &mut space.line, scratch);
            for (x, value) in space.line.iter().enumerate() {
                space.spectrum[x * SIDE + y] = *value;
            }
        }
        self.down
            .process_with_scratch(&mut space.spectrum, &mut space.scratch);
    }

    fn back(&self, space: &mut Space, square: &mut [f32]) {
        let longest = self
            .back_across
            .get_scratch_len()
            .max(self.back_down.get_inplace_scratch_len());
        space
            .scratch
            .resize(longest.max(space.scratch.len()), Complex::default());
        self.back_down
            .process_with_scratch(&mut space.spectrum, &mut space.scratch);
        let scale = 1.0 / (SIDE * SIDE) as f32;
        for (y, row) in square.chunks_exact_mut(SIDE).enumerate() {
            for (x, value) in space.line.iter_mut().enumerate() {
                *value = space.spectrum[x * SIDE + y] * scale;
            }
            // What real samples cannot have is rounding.
            space.line[0].im = 0.0;
            space.line[HALF - 1].im = 0.0;
            let scratch = &mut space.scratch[..self.back_across.get_scratch_len()];
            let _ = self
                .back_across
                .process_with_scratch(&mut space.line, row, scratch);
        }
    }
}
