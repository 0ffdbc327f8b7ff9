//! Filters made of a lens's local spectra: a plate is cut into overlapping squares, each is filtered as if the
//! lens's blur were that of its middle all over, and they are put together under smooth windows.

use super::prior::response;
use super::squares::Squares;
use super::transform::{Space, Transform};
use crate::{LocalKernels, RenderWindow, Scene, kernel_reach};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use seidel_optics::error::Result;
use std::f64::consts::PI;

/// Least and largest side of a square, px.
const SIDES: [usize; 2] = [48, 768];
/// A square is at least so many times as wide as kernels from end to end, up to the largest.
const WIDTHS: f64 = 1.0;
/// Means over waves look at one of so many, evenly spread as long as sides of squares are no multiples of it.
const EVERY: usize = 5;

/// The local spectra of a lens over a plate.
pub(super) struct Local {
    pub(super) squares: Squares,
    /// The transfer function of each square, column by column.
    spectra: Vec<Vec<Complex<f32>>>,
    /// |D|^2 of the differences that the prior looks at, column by column.
    pub(super) slopes: Vec<f32>,
    transform: Transform,
}

impl Local {
    /// Of a scene at one vergence, for a plane of some channel weights.
    ///
    /// # Errors
    /// A lens that cannot be drawn, and a vergence that varies.
    pub(super) fn new(scene: &Scene, weights: &[f64]) -> Result<Self> {
        let kernels = LocalKernels::new(scene, weights)?;
        let far = kernel_reach(scene, RenderWindow::whole(scene), kernels.vergence_per_m());
        let widest = (far.left_px + far.right_px).max(far.up_px + far.down_px);
        let mut side = SIDES[0];
        while side < SIDES[1] && (side as f64) < WIDTHS * widest {
            side *= 2;
        }
        let transform = Transform::new(side);
        let squares = Squares::new((scene.width, scene.height), side);
        let spectra = squares
            .places
            .par_iter()
            .map(|place| Ok(transform.of_kernel(&kernels.at(squares.middle(*place))?)))
            .collect::<Result<_>>()?;
        let wave = |k: usize| k as f64 / side as f64;
        Ok(Self {
            spectra,
            slopes: (0..transform.half())
                .flat_map(|x| (0..side).map(move |y| response(wave(x), wave(y)) as f32))
                .collect(),
            transform,
            squares,
        })
    }

    /// The transfer function about a point of the plate, of every wave that a square `times` smaller has.
    pub(super) fn spectrum_at(&self, at: (f64, f64), times: usize) -> Vec<Complex<f32>> {
        let side = self.squares.side;
        let about = self.squares.about(at);
        let small = side / times;
        let columns = (0..small / 2 + 1).map(|x| x * times);
        let rows = |x: usize| (0..small).map(move |y| x * side + y * times);
        columns
            .flat_map(rows)
            .map(|wave| {
                let parts = about.iter();
                parts.map(|(k, share)| self.spectra[*k][wave] * share).sum()
            })
            .collect()
    }

    /// `plane`, dark beyond its edges, with every square filtered by what `filter` makes of its transfer function
    /// and of |D|^2; squares without any `share` are left out. Symmetric where `filter` is real.
    pub(super) fn filtered(
        &self,
        plane: &[f32],
        share: Option<&[f32]>,
        filter: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        let places = self.squares.places.par_iter();
        let parts: Vec<Option<Vec<f32>>> = places
            .zip(&self.spectra)
            .map_init(Space::default, |space, (place, spectrum)| {
                if share.is_some_and(|share| self.squares.is_dark(share, *place)) {
                    return None;
                }
                let mut square = self.squares.cut(plane, *place);
                self.transform.forward(&mut square, space);
                for ((value, h), slope) in space.spectrum.iter_mut().zip(spectrum).zip(&self.slopes)
                {
                    *value *= filter(*h, *slope);
                }
                self.transform.back(space, &mut square);
                Some(square)
            })
            .collect();
        self.squares.put_together(&parts)
    }

    /// Mean over all waves of what `share` makes of the transfer function and |D|^2, of each square, smooth between them.
    pub(super) fn mean_over_waves(
        &self,
        share: impl Fn(Complex<f32>, f32) -> f32 + Sync,
    ) -> Vec<f32> {
        let parts: Vec<Option<Vec<f32>>> = self
            .spectra
            .par_iter()
            .map(|spectrum| {
                let waves = spectrum.iter().zip(&self.slopes).step_by(EVERY);
                let sum: f64 = waves.map(|(h, slope)| f64::from(share(*h, *slope))).sum();
                let count = spectrum.len().div_ceil(EVERY) as f64;
                Some(self.squares.even((sum / count) as f32))
            })
            .collect();
        self.squares.put_together(&parts)
    }

    /// Median power of white noise in `plane`, as each square has it in waves of which the lens passes less than
    /// `passed` of the power; squares wholly on the plane that have at least `count` such waves and a `share` all over.
    pub(super) fn quiet_powers(
        &self,
        plane: &[f32],
        share: Option<&[f32]>,
        passed: f32,
        count: usize,
    ) -> Vec<f64> {
        let side = self.transform.side;
        // A window that rises slowly, that strong slow waves be not seen as fast ones.
        let hann: Vec<f32> = (0..side)
            .map(|k| (PI * (k as f64 + 0.5) / side as f64).sin().powi(2) as f32)
            .collect();
        let energy = hann.iter().map(|w| w * w).sum::<f32>().powi(2);
        let (squares, places) = (&self.squares, self.squares.places.par_iter());
        places
            .zip(&self.spectra)
            .map_init(Space::default, |space, (place, spectrum)| {
                if !squares.is_whole(*place)
                    || share.is_some_and(|share| !squares.is_full(share, *place))
                {
                    return None;
                }
                let mut square = Vec::with_capacity(side * side);
                for (row, wy) in squares.stretches(*place).zip(&hann) {
                    let samples = plane[row.plate..][..side].iter().zip(&hann);
                    square.extend(samples.map(|(sample, wx)| wy * wx * sample));
                }
                self.transform.forward(&mut square, space);
                let quiet = space.spectrum.iter().zip(spectrum);
                let mut powers: Vec<f32> = quiet
                    .filter(|(_, h)| h.norm_sqr() < passed)
                    .map(|(value, _)| value.norm_sqr() / energy)
                    .collect();
                let middle = powers.len() / 2;
                (powers.len() >= count).then(|| {
                    let (_, median, _) = powers.select_nth_unstable_by(middle, f32::total_cmp);
                    f64::from(*median)
                })
            })
            .flatten()
            .collect()
    }
}
