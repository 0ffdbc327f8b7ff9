//! The fit of one light: the smallest non-negative source whose blur explains a bright region of a plate.
//!
//! Over the window that the light reaches, the plate is y = K s + P c + n. The columns of K are the kernels of the pixels
//! that may be sources, s >= 0 is their light, and P c is a plane: the picture around and behind the light. The noise n has
//! at pixel i the variance s_i² = s² + t² + (e y_i)², with s the noise of a typical sample, t the texture of the picture and e
//! the relative error of the lens. The fit minimises
//!
//! ```text
//! |(y - K s - P c) / s_i|² / 2 + l sum |s_p - s_q|
//! ```
//!
//! The sum is the total variation of s over neighbours p and q, among them pixels that are no sources. It is handled by
//! iteratively reweighted least squares, and each quadratic by coordinate descent on its normal equations. The weight l is
//! lowered until the residual is that of the noise (the discrepancy principle). Clipped samples only have to be reached.

use super::light_kernels::{Column, KernelGrid};
use crate::{LocalKernels, RenderWindow};
use rayon::prelude::*;
use seidel_optics::error::Result;

/// Largest number of pixels that may be sources.
const MAX_SOURCES: usize = 2000;
/// Weight from which the samples of a kernel bound the light of its source, as a share of its largest.
const BOUNDING_WEIGHT: f32 = 0.05;
/// Least bound of the light of a source, as a share of the largest in the region.
const MIN_BOUND_SHARE: f32 = 0.01;
/// Largest number of elements of K, and of the normal equations, for each pixel of the plate: they bound memory.
const ELEMENTS_PER_PIXEL: usize = 8;
/// Ratio of two weights l that are tried one after the other.
const WEIGHT_STEP: f64 = 4.0;
/// Number of weights l that are tried.
const WEIGHTS: usize = 11;
/// Root mean square residual, in standard deviations, at which l is small enough.
const WANTED_MISFIT: f64 = 1.05;
/// Times that the total variation is reweighted for each l.
const REWEIGHTINGS: usize = 2;
/// Sweeps of coordinate descent over all unknowns for each reweighting.
const SWEEPS: usize = 12;
/// Differences below this share of the brightest source are weighted alike.
const SMALL_DIFFERENCE: f64 = 1e-3;
/// Least share of the light of a clipped source that falls on samples which are not clipped: a smaller one does not
/// determine the source.
const MIN_MEASURED_SHARE: f64 = 0.01;
/// Largest texture of the picture around a light, as a share of the light's brightest sample: where it is larger, the light
/// is a part of the picture like others.
const MAX_TEXTURE_SHARE: f64 = 0.02;
/// Times that clipped samples which the light does not reach are found and the fit is repeated.
const CLIP_PASSES: usize = 3;

/// The plate in which lights are fitted.
pub(super) struct FitInputs<'a> {
    pub(super) kernels: &'a LocalKernels<'a>,
    /// The samples of the plate.
    pub(super) plate: &'a [f32],
    /// Columns and rows of the plate.
    pub(super) size: (usize, usize),
    /// Standard deviation of a typical sample.
    pub(super) deviation: f64,
    /// Relative error of the lens.
    pub(super) model_error: f64,
    pub(super) clip_level: Option<f32>,
}

/// A fitted light.
pub(super) struct FittedLight {
    /// The pixels of the plate that are sources, and their light.
    pub(super) sources: Vec<(usize, f32)>,
    /// The part of the plate that the light reaches.
    pub(super) window: RenderWindow,
    /// The light that the sources bring to each pixel of the window.
    pub(super) blurred: Vec<f32>,
    /// Relative error of the lens that explains the residual.
    pub(super) model_error: f64,
}

impl FitInputs<'_> {
    /// Fits the light of `region`, pixels of the plate, to `samples`, the plate without the other lights. Returns `None` if
    /// the region is too large for one light, or if no light explains it. The multiplications are taken off the `budget`;
    /// nothing is fitted beyond it.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn fit(
        &self,
        region: &[usize],
        samples: &[f32],
        budget: &mut f64,
    ) -> Result<Option<FittedLight>> {
        let width = self.size.0;
        let place = |k: &usize| (k % width, k / width);
        let mut first = (usize::MAX, usize::MAX);
        let mut last = (0, 0);
        for (x, y) in region.iter().map(place) {
            first = (first.0.min(x), first.1.min(y));
            last = (last.0.max(x), last.1.max(y));
        }
        let grid = KernelGrid::new(self.kernels, first, last)?;
        let window = grid.window(last, self.size);
        let search_work = (region.len() * grid.kernel_area()) as f64;
        if search_work > *budget {
            return Ok(None);
        }
        *budget -= search_work;
        let sources = self.possible_sources(region, samples, &grid);
        let count = sources.len();
        let elements = count * grid.kernel_area().max(count);
        let most = ELEMENTS_PER_PIXEL * self.plate.len();
        if count == 0 || count > MAX_SOURCES || elements > most {
            return Ok(None);
        }
        let work = grid.work(count, last);
        if work > *budget {
            return Ok(None);
        }
        *budget -= work;
        let fit = LightFit::new(self, &grid, window, &sources, samples);
        Ok(fit.solve().map(|solved| FittedLight {
            sources: (sources.iter().copied())
                .zip(solved.light)
                .filter(|(_, light)| *light > 0.0)
                .collect(),
            window,
            blurred: solved.blurred,
            model_error: solved.model_error,
        }))
    }

    /// Returns the pixels of `region` that can be sources. Light is not negative, so that no source is brighter than any
    /// sample that it reaches allows.
    fn possible_sources(&self, region: &[usize], samples: &[f32], grid: &KernelGrid) -> Vec<usize> {
        let (width, height) = self.size;
        let bound = |pixel: usize| {
            let (x, y) = (pixel % width, pixel / width);
            let kernel = grid.nearest((x, y));
            let peak = kernel.weights.iter().fold(0.0_f32, |most, w| most.max(*w));
            let mut bound = f32::INFINITY;
            for (k, weight) in kernel.weights.iter().enumerate() {
                let at_x = x as i32 + kernel.left + (k % kernel.width) as i32;
                let at_y = y as i32 + kernel.top + (k / kernel.width) as i32;
                let inside =
                    (0..width as i32).contains(&at_x) && (0..height as i32).contains(&at_y);
                if *weight <= BOUNDING_WEIGHT * peak || !inside {
                    continue;
                }
                let at = at_y as usize * width + at_x as usize;
                if self.is_clipped(at) {
                    continue;
                }
                let most = samples[at].max(0.0) + 3.0 * self.deviation_at(at) as f32;
                bound = bound.min(most / weight);
            }
            bound
        };
        let bounds: Vec<f32> = region.par_iter().map(|pixel| bound(*pixel)).collect();
        let finite = bounds.iter().copied().filter(|bound| bound.is_finite());
        let least = MIN_BOUND_SHARE * finite.fold(0.0, f32::max);
        let possible = region.iter().zip(&bounds);
        possible
            .filter(|(_, bound)| **bound > least)
            .map(|(pixel, _)| *pixel)
            .collect()
    }

    fn is_clipped(&self, pixel: usize) -> bool {
        self.clip_level
            .is_some_and(|level| self.plate[pixel] >= level)
    }

    /// Returns the standard deviation of a sample: noise and errors of the lens.
    fn deviation_at(&self, pixel: usize) -> f64 {
        self.deviation
            .hypot(self.model_error * f64::from(self.plate[pixel]))
    }
}

/// The least-squares problem of one light.
struct LightFit<'a> {
    /// The columns of K and P over the window.
    columns: Vec<Column>,
    /// Columns of the window.
    width: usize,
    source_count: usize,
    /// Neighbours of each source: their indices, or those of pixels that are no sources as `None`.
    neighbours: Vec<[Option<usize>; 4]>,
    /// The samples of the window.
    samples: Vec<f32>,
    /// Standard deviation of each sample.
    deviations: Vec<f64>,
    /// Whether a sample is clipped.
    clipped: Vec<bool>,
    inputs: &'a FitInputs<'a>,
}

/// A solved problem.
struct Solved {
    light: Vec<f32>,
    blurred: Vec<f32>,
    model_error: f64,
}

/// The normal equations, and the unknowns that solve them.
struct Normal {
    matrix: Vec<Vec<f32>>,
    right: Vec<f64>,
    unknowns: Vec<f64>,
}

impl<'a> LightFit<'a> {
    fn new(
        inputs: &'a FitInputs<'a>,
        grid: &KernelGrid,
        window: RenderWindow,
        sources: &[usize],
        samples: &[f32],
    ) -> Self {
        let width = inputs.size.0;
        let count = window.width * window.height;
        let mut columns: Vec<Column> = sources
            .par_iter()
            .map(|pixel| grid.column((pixel % width, pixel / width), window))
            .collect();
        let along = |at: usize, size: usize| (at as f32 + 0.5) / size as f32 - 0.5;
        let full = |value: &dyn Fn(usize) -> f32| {
            Column::full(window.width, (0..count).map(value).collect())
        };
        columns.push(full(&|_| 1.0));
        columns.push(full(&|k| along(k % window.width, window.width)));
        columns.push(full(&|k| along(k / window.width, window.height)));
        let index_of = |pixel: Option<usize>| pixel.and_then(|p| sources.binary_search(&p).ok());
        let neighbours = sources.iter().map(|pixel| {
            [
                index_of(pixel.checked_sub(1)),
                index_of(Some(pixel + 1)),
                index_of(pixel.checked_sub(width)),
                index_of(Some(pixel + width)),
            ]
        });
        let pixels = || {
            (0..count)
                .map(|k| (window.row + k / window.width) * width + window.column + k % window.width)
        };
        Self {
            columns,
            width: window.width,
            source_count: sources.len(),
            neighbours: neighbours.collect(),
            samples: window.cut(width, samples),
            deviations: pixels().map(|pixel| inputs.deviation_at(pixel)).collect(),
            clipped: pixels().map(|pixel| inputs.is_clipped(pixel)).collect(),
            inputs,
        }
    }

    fn solve(mut self) -> Option<Solved> {
        let mut used: Vec<bool> = self.clipped.iter().map(|clipped| !clipped).collect();
        // Texture is what remains far from the light; the first fit finds it.
        let mut normal = self.normal_equations(&used);
        self.minimise(&mut normal, &used);
        let texture = self.texture_variance(&normal.unknowns, &used);
        if texture.sqrt() > MAX_TEXTURE_SHARE * self.brightest(&normal.unknowns) {
            return None;
        }
        for deviation in &mut self.deviations {
            *deviation = (*deviation * *deviation + texture).sqrt();
        }
        let mut misfit = 0.0;
        for pass in 0..CLIP_PASSES {
            normal = self.normal_equations(&used);
            misfit = self.minimise(&mut normal, &used);
            let model = self.model(&normal.unknowns);
            let short = |k: usize| self.clipped[k] && !used[k] && model[k] < self.samples[k];
            let found: Vec<usize> = (0..used.len()).filter(|k| short(*k)).collect();
            if found.is_empty() || pass + 1 == CLIP_PASSES {
                break;
            }
            for k in found {
                used[k] = true;
            }
        }
        let light: Vec<f32> = normal.unknowns[..self.source_count]
            .iter()
            .map(|v| *v as f32)
            .collect();
        let blurred = self.model(&self.without_plane(&normal.unknowns));
        let sum = |use_all: bool| -> f64 {
            let samples = blurred.iter().zip(&self.clipped);
            let counted = samples.filter(|(_, clipped)| use_all || !**clipped);
            counted.map(|(light, _)| f64::from(*light)).sum()
        };
        if sum(false) < MIN_MEASURED_SHARE * sum(true) {
            return None;
        }
        Some(Solved {
            light,
            blurred,
            model_error: self.inputs.model_error * misfit.max(1.0),
        })
    }

    /// Returns K s + P c.
    fn model(&self, unknowns: &[f64]) -> Vec<f32> {
        let mut model = vec![0.0; self.samples.len()];
        for (column, value) in self.columns.iter().zip(unknowns) {
            if *value != 0.0 {
                column.add_to(&mut model, self.width, *value as f32);
            }
        }
        model
    }

    /// Returns the brightest sample of K s.
    fn brightest(&self, unknowns: &[f64]) -> f64 {
        let light = self.model(&self.without_plane(unknowns));
        f64::from(light.iter().fold(0.0_f32, |most, v| most.max(*v)))
    }

    /// Returns `unknowns` with c = 0.
    fn without_plane(&self, unknowns: &[f64]) -> Vec<f64> {
        let mut light = unknowns.to_vec();
        light[self.source_count..].fill(0.0);
        light
    }

    /// Returns the variance of the residual, beyond the noise, where the light is weak.
    fn texture_variance(&self, unknowns: &[f64], used: &[bool]) -> f64 {
        let light = self.model(&self.without_plane(unknowns));
        let model = self.model(unknowns);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for k in 0..self.samples.len() {
            let deviation = self.deviations[k];
            if used[k] && f64::from(light[k]) < deviation.max(0.1 * f64::from(self.samples[k])) {
                sum += f64::from(self.samples[k] - model[k]).powi(2) - deviation * deviation;
                count += 1.0;
            }
        }
        (sum / count.max(1.0)).max(0.0)
    }

    /// Forms the normal equations of the `used` samples.
    fn normal_equations(&self, used: &[bool]) -> Normal {
        let weights: Vec<f32> = (self.deviations.iter().zip(used))
            .map(|(deviation, used)| if *used { deviation.recip() as f32 } else { 0.0 })
            .collect();
        let columns: Vec<Column> = (self.columns.par_iter())
            .map(|column| column.scaled(&weights, self.width))
            .collect();
        let samples = self.samples.iter().zip(&weights).map(|(v, w)| v * w);
        let samples = Column::full(self.width, samples.collect());
        let half: Vec<Vec<f32>> = (0..columns.len())
            .into_par_iter()
            .map(|j| {
                (0..=j)
                    .map(|k| columns[j].dot(&columns[k]) as f32)
                    .collect()
            })
            .collect();
        let count = columns.len();
        let matrix = (0..count)
            .map(|j| (0..count).map(|k| half[j.max(k)][j.min(k)]).collect())
            .collect();
        Normal {
            matrix,
            right: columns.iter().map(|column| column.dot(&samples)).collect(),
            unknowns: vec![0.0; count],
        }
    }

    /// Lowers the weight of the total variation until the residual is that of the noise. Returns the misfit: the root mean
    /// square residual, in standard deviations, where the light is strong.
    fn minimise(&self, normal: &mut Normal, used: &[bool]) -> f64 {
        let steepest = normal.right[..self.source_count]
            .iter()
            .fold(0.0, |a: f64, b| a.max(*b));
        let mut weight = steepest / WEIGHT_STEP;
        let mut misfit = f64::INFINITY;
        for _ in 0..WEIGHTS {
            for _ in 0..REWEIGHTINGS {
                self.descend(normal, weight);
            }
            misfit = self.misfit(&normal.unknowns, used);
            if misfit < WANTED_MISFIT {
                break;
            }
            weight /= WEIGHT_STEP;
        }
        misfit
    }

    fn misfit(&self, unknowns: &[f64], used: &[bool]) -> f64 {
        let light = self.model(&self.without_plane(unknowns));
        let model = self.model(unknowns);
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for k in 0..self.samples.len() {
            if used[k] && f64::from(light[k]) > self.deviations[k] {
                sum += (f64::from(self.samples[k] - model[k]) / self.deviations[k]).powi(2);
                count += 1.0;
            }
        }
        (sum / count.max(1.0)).sqrt()
    }

    /// Sweeps over the unknowns, with the total variation weighted quadratically around the present sources.
    fn descend(&self, normal: &mut Normal, weight: f64) {
        let Normal {
            matrix,
            right,
            unknowns,
        } = normal;
        let brightest = unknowns[..self.source_count]
            .iter()
            .fold(0.0, |a: f64, b| a.max(*b));
        let small = (SMALL_DIFFERENCE * brightest).max(f64::MIN_POSITIVE.sqrt());
        let pull: Vec<[f64; 4]> = (0..self.source_count)
            .map(|j| {
                self.neighbours[j].map(|other| {
                    let difference = unknowns[j] - other.map_or(0.0, |k| unknowns[k]);
                    // Before there is a source all differences are zero, and the prior says nothing.
                    if brightest > 0.0 {
                        weight / difference.abs().max(small)
                    } else {
                        0.0
                    }
                })
            })
            .collect();
        // The negative gradient of the data term.
        let mut descent: Vec<f64> = (matrix.iter().zip(right.iter()))
            .map(|(row, right)| {
                let product: f64 = row
                    .iter()
                    .zip(unknowns.iter())
                    .map(|(a, b)| f64::from(*a) * b)
                    .sum();
                right - product
            })
            .collect();
        for _ in 0..SWEEPS {
            for j in 0..unknowns.len() {
                let (mut gradient, mut curvature) = (descent[j], f64::from(matrix[j][j]));
                if let Some(pull) = pull.get(j) {
                    for (pull, other) in pull.iter().zip(&self.neighbours[j]) {
                        gradient -= pull * (unknowns[j] - other.map_or(0.0, |k| unknowns[k]));
                        curvature += pull;
                    }
                }
                if curvature <= 0.0 {
                    continue;
                }
                let mut value = unknowns[j] + gradient / curvature;
                if j < self.source_count {
                    value = value.max(0.0);
                }
                let change = value - unknowns[j];
                if change != 0.0 {
                    unknowns[j] = value;
                    for (descent, element) in descent.iter_mut().zip(&matrix[j]) {
                        *descent -= f64::from(*element) * change;
                    }
                }
            }
        }
    }
}
