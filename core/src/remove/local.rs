//! Filters made of a lens's local spectra: a plate is cut into overlapping squares, each is filtered as if the
//! lens's blur were that of its middle all over, and they are put together under smooth windows.

use super::prior::response;
use super::transform::{Space, Transform};
use crate::error::Result;
use crate::render::{LocalKernels, Scene, Window, reach};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Least and largest side of a square, px.
const SIDES: [usize; 2] = [96, 768];
/// Share of a square that it has in common with the next.
const COMMON: f64 = 0.5;
/// Rows that one thread puts together.
const BAND: usize = 32;
/// A square is at least so many times as wide as kernels from end to end, up to the largest.
const WIDTHS: f64 = 1.0;

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
    /// Along one axis: rises and falls as a sine where neighbours share samples.
    window: Vec<f32>,
}

impl Local {
    /// Of a scene at one vergence, for a plane of some channel weights.
    ///
    /// # Errors
    /// A lens that cannot be drawn, and a vergence that varies.
    pub(super) fn new(scene: &Scene, weights: &[f64]) -> Result<Self> {
        let kernels = LocalKernels::new(scene, weights)?;
        let far = reach(scene, Window::whole(scene), kernels.vergence_per_m());
        let widest = (far.left_px + far.right_px).max(far.up_px + far.down_px);
        let mut side = SIDES[0];
        while side < SIDES[1] && (side as f64) < WIDTHS * widest {
            side *= 2;
        }
        let transform = Transform::new(side);
        let ramp = (COMMON * side as f64) as usize;
        let (size, hop) = ((scene.width, scene.height), side - ramp);
        let starts = |size: usize| {
            let count = (size + ramp).div_ceil(hop);
            // As far beyond one edge as beyond the other.
            let before = (ramp + count * hop - size) / 2;
            (0..count).map(move |k| (k * hop) as i32 - before as i32)
        };
        let squares: Vec<(i32, i32)> = starts(size.1)
            .flat_map(|y| starts(size.0).map(move |x| (x, y)))
            .collect();
        let middle = |start: i32, size: usize| {
            (f64::from(start) + side as f64 / 2.0).clamp(0.0, size as f64)
        };
        let spectra = squares
            .par_iter()
            .map(|(x, y)| {
                let kernel = kernels.at((middle(*x, size.0), middle(*y, size.1)))?;
                Ok(transform.of_kernel(&kernel))
            })
            .collect::<Result<_>>()?;
        let wave = |k: usize| k as f64 / side as f64;
        Ok(Self {
            size,
            squares,
            spectra,
            slopes: (0..transform.half())
                .flat_map(|x| (0..side).map(move |y| response(wave(x), wave(y)) as f32))
                .collect(),
            transform,
            window: (0..side)
                .map(|k| {
                    let inwards = (k.min(side - 1 - k) as f64 + 0.5) / ramp as f64;
                    (0.5 * PI * inwards.min(1.0)).sin() as f32
                })
                .collect(),
        })
    }

    /// `plane`, dark beyond its edges, with every square filtered by what `filter` makes of its transfer function
    /// and of |D|^2; squares without any `share` are left out. Symmetric where `filter` is real.
    pub(super) fn filtered(
        &self,
        plane: &[f32],
        share: Option<&[f32]>,
        filter: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Vec<f32> {
        let parts: Vec<Option<Vec<f32>>> = self
            .squares
            .par_iter()
            .zip(&self.spectra)
            .map_init(Space::default, |space, (place, spectrum)| {
                if share.is_some_and(|share| self.is_dark(share, *place)) {
                    return None;
                }
                let mut square = self.cut(plane, *place);
                self.transform.forward(&mut square, space);
                for ((value, h), slope) in space.spectrum.iter_mut().zip(spectrum).zip(&self.slopes)
                {
                    *value *= filter(*h, *slope);
                }
                self.transform.back(space, &mut square);
                Some(square)
            })
            .collect();
        self.put_together(&parts, plane.len())
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
                let waves = spectrum.iter().zip(&self.slopes);
                let sum: f64 = waves.map(|(h, slope)| f64::from(share(*h, *slope))).sum();
                let mean = (sum / spectrum.len() as f64) as f32;
                // Windowed once here and once when squares are put together.
                let rows = self.window.iter();
                Some(
                    rows.flat_map(|wy| self.window.iter().map(move |wx| mean * wy * wx))
                        .collect(),
                )
            })
            .collect();
        self.put_together(&parts, self.size.0 * self.size.1)
    }

    /// The sum of windowed squares, in order, so that it does not depend on threads.
    fn put_together(&self, parts: &[Option<Vec<f32>>], count: usize) -> Vec<f32> {
        let mut out = vec![0.0; count];
        let bands = out.par_chunks_mut(BAND * self.size.0).enumerate();
        bands.for_each(|(band, out)| {
            for (place, part) in self.squares.iter().zip(parts) {
                if let Some(part) = part {
                    self.add(part, *place, band * BAND, out);
                }
            }
        });
        out
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
        self.squares
            .par_iter()
            .zip(&self.spectra)
            .map_init(Space::default, |space, (place, spectrum)| {
                let whole = self
                    .stretches(*place)
                    .map(|s| s.inside.len())
                    .sum::<usize>();
                if whole < side * side || share.is_some_and(|share| !self.is_full(share, *place)) {
                    return None;
                }
                let mut square = Vec::with_capacity(side * side);
                for (row, wy) in self.stretches(*place).zip(&hann) {
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

    fn is_full(&self, share: &[f32], place: (i32, i32)) -> bool {
        let mut stretches = self.stretches(place);
        stretches.all(|s| share[s.plate..][..s.inside.len()].iter().all(|v| *v > 0.0))
    }

    fn is_dark(&self, share: &[f32], place: (i32, i32)) -> bool {
        let mut stretches = self.stretches(place);
        stretches.all(|s| share[s.plate..][..s.inside.len()].iter().all(|v| *v == 0.0))
    }

    /// The windowed square at `place`.
    fn cut(&self, plane: &[f32], place: (i32, i32)) -> Vec<f32> {
        let mut square = vec![0.0; self.transform.side * self.transform.side];
        for Stretch { inside, plate, wy } in self.stretches(place) {
            let samples = plane[plate..][..inside.len()].iter();
            let windows = &self.window[inside.start % self.transform.side..];
            for ((out, sample), wx) in square[inside].iter_mut().zip(samples).zip(windows) {
                *out = wy * wx * sample;
            }
        }
        square
    }

    /// Adds what of a windowed square lies on the rows of the plane from `first` on, `out`.
    fn add(&self, square: &[f32], place: (i32, i32), first: usize, out: &mut [f32]) {
        let before = first * self.size.0;
        for Stretch { inside, plate, wy } in self.stretches(place) {
            if plate < before || plate >= before + out.len() {
                continue;
            }
            let samples = square[inside.clone()].iter();
            let windows = &self.window[inside.start % self.transform.side..];
            for ((out, sample), wx) in out[plate - before..].iter_mut().zip(samples).zip(windows) {
                *out += wy * wx * sample;
            }
        }
    }

    /// The rows of the square at `place` that lie on the plane.
    fn stretches(&self, (left, top): (i32, i32)) -> impl Iterator<Item = Stretch> + '_ {
        let (width, height) = (self.size.0 as i32, self.size.1 as i32);
        let columns =
            (-left).max(0) as usize..(width - left).clamp(0, self.transform.side as i32) as usize;
        let rows =
            (-top).max(0) as usize..(height - top).clamp(0, self.transform.side as i32) as usize;
        let rows = if columns.is_empty() { 0..0 } else { rows };
        rows.map(move |y| Stretch {
            inside: y * self.transform.side + columns.start..y * self.transform.side + columns.end,
            plate: (top + y as i32) as usize * self.size.0 + (left + columns.start as i32) as usize,
            wy: self.window[y],
        })
    }
}

/// A row of a square, as far as it lies on the plane.
struct Stretch {
    /// Its samples in the square.
    inside: std::ops::Range<usize>,
    /// Its first sample on the plane.
    plate: usize,
    /// Its window.
    wy: f32,
}
