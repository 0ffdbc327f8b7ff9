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
//! iteratively reweighted least squares, and each quadratic by coordinate descent (`light_equations`). The weight l is lowered
//! until the residual is that of the noise (the discrepancy principle), or errors of the lens keep it from shrinking. Clipped
//! samples only have to be reached.

use super::light_equations::{Equations, work};
use super::light_kernels::{Column, KernelGrid};
use super::light_lattice::SourceLattice;
use crate::{LocalKernels, RenderWindow};
use rayon::prelude::*;
use seidel_optics::error::Result;

/// Largest number of sources. Larger lights get a source every few pixels.
const MAX_SOURCES: usize = 8000;
/// Weight from which the samples of a kernel bound the light of its source, as a share of its largest.
const BOUNDING_WEIGHT: f32 = 0.05;
/// Least bound of the light of a source, as a share of the largest in the region.
const MIN_BOUND_SHARE: f32 = 0.01;
/// Largest number of elements of K, or of the normal equations, for each pixel of the plate: it bounds memory.
const ELEMENTS_PER_PIXEL: usize = 24;
/// Largest distance of sources, as a share of the width of the kernels: their light is smooth at that scale.
const MAX_SPACING_SHARE: f64 = 0.03;
/// Ratio of two weights l that are tried one after the other.
const WEIGHT_STEP: f64 = 4.0;
/// Number of weights l that are tried.
const WEIGHTS: usize = 11;
/// Number of weights l after which most fits are done.
const USUAL_WEIGHTS: usize = 7;
/// Number of weights l before texture is looked at: stronger ones leave most of a light in the residual.
const WEIGHTS_FOR_TEXTURE: usize = 4;
/// Number of fits of one light: the first finds the texture.
const FITS: f64 = 2.0;
/// Root mean square residual, in standard deviations, at which l is small enough.
const WANTED_MISFIT: f64 = 1.05;
/// Ratio of two successive misfits from which l is small enough: the rest are errors of the lens.
const PLATEAU: f64 = 0.8;
/// Times that the total variation is reweighted for each l.
const REWEIGHTINGS: usize = 2;
/// Sweeps of coordinate descent over all unknowns for each reweighting.
const SWEEPS: usize = 12;
/// Differences below this share of the brightest source are weighted alike.
const SMALL_DIFFERENCE: f64 = 1e-3;
/// Least share of the light of a clipped source that falls on samples which are not clipped: a smaller one does not
/// determine the source.
const MIN_MEASURED_SHARE: f64 = 0.01;
/// Largest relative error of the lens with which a light counts as explained: others keep their blur. It is the root mean
/// square residual over the local light; a lens 5 % too wide causes 0.5 to 2 %.
const MAX_MODEL_ERROR: f64 = 0.01;
/// Largest texture of the picture around a light, as a share of the light's brightest sample: where it is larger, the light
/// is a part of the picture like others.
const MAX_TEXTURE_SHARE: f64 = 0.02;
/// Median of the square of a standard normal deviate.
const MEDIAN_SQUARE_NORMAL: f64 = 0.454_936;
/// Ratio of two successive variances of texture, and of two brightest samples, from which the fit does not change any more.
const TEXTURE_PLATEAU: f64 = 0.9;
/// Texture below this share of the noise is ignored.
const NEGLIGIBLE_TEXTURE: f64 = 0.1;
/// Largest share of the pixels of a light that lie beyond the blur of its clipped samples: more are a bright surface that is clipped in
/// part, and light of unknown brightness would take the place of the surface beside it.
const MAX_BEYOND_CLIPPED: f64 = 0.25;
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

/// The outcome of a fit.
pub(super) enum Fit {
    Light(FittedLight),
    /// A light that the lens does not explain.
    Unexplained,
    /// A part of the picture like others, or a light that is too large.
    Picture,
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
    /// Mean light of the sources over the standard deviation of the light of one alone, from noise and texture.
    pub(super) signal_to_noise: f64,
}

impl FitInputs<'_> {
    /// Fits the light of `region`, pixels of the plate, to `samples`, the plate without the other lights. The multiplications
    /// are taken off the `budget`; nothing is fitted beyond it.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn fit(&self, region: &[usize], samples: &[f32], budget: &mut f64) -> Result<Fit> {
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
        if self.is_partly_clipped(region, grid.nearest(first).variance_px2()) {
            return Ok(Fit::Unexplained);
        }
        let search_work = (region.len() * grid.kernel_area()) as f64;
        if search_work > *budget {
            return Ok(Fit::Picture);
        }
        *budget -= search_work;
        let possible = self.possible_sources(region, samples, &grid);
        let lattices = (1..=grid.max_spacing(MAX_SPACING_SHARE))
            .map(|spacing| SourceLattice::new(&possible, spacing, width));
        let is_solvable = |lattice: &SourceLattice| {
            let count = lattice.pixels.len();
            let area = grid.kernel_area();
            let elements = count
                * if count > 2 * area {
                    area
                } else {
                    area.max(count)
                };
            let most = ELEMENTS_PER_PIXEL * self.plate.len();
            (1..=MAX_SOURCES).contains(&count)
                && elements <= most
                && self.work(count, &grid, last) <= *budget
        };
        let Some(sources) = lattices.into_iter().find(is_solvable) else {
            return Ok(Fit::Picture);
        };
        *budget -= self.work(sources.pixels.len(), &grid, last);
        let fit = LightFit::new(self, &grid, window, &sources, samples);
        let solved = match fit.solve() {
            Ok(solved) => solved,
            Err(refused) => return Ok(refused),
        };
        Ok(Fit::Light(FittedLight {
            sources: sources.lit_pixels(&solved.light, self.size.1),
            window,
            blurred: solved.blurred,
            model_error: solved.model_error,
            signal_to_noise: solved.signal_to_noise,
        }))
    }

    /// Returns about how many multiplications the fit of `count` sources takes.
    fn work(&self, count: usize, grid: &KernelGrid, last: (usize, usize)) -> f64 {
        let sweeps = SWEEPS * REWEIGHTINGS * USUAL_WEIGHTS;
        FITS * work(count, grid.kernel_area(), grid.work(count, last), sweeps)
    }

    /// Returns the pixels of `region` that can be sources. Light is not negative, so that no source is brighter than any
    /// sample that it reaches allows. Returns none if most sources reach clipped samples only: nothing determines them.
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
        if 2 * finite.clone().count() < bounds.len() {
            return Vec::new();
        }
        let least = MIN_BOUND_SHARE * finite.fold(0.0, f32::max);
        let possible = region.iter().zip(&bounds);
        possible
            .filter(|(_, bound)| **bound > least)
            .map(|(pixel, _)| *pixel)
            .collect()
    }

    /// Returns whether many pixels of `region` lie beyond the blur of its clipped samples. The blur reaches two radii and a pixel far,
    /// those of a disc with this variance along both axes together.
    fn is_partly_clipped(&self, region: &[usize], variance_px2: f64) -> bool {
        let width = self.size.0;
        let place = |k: &usize| ((k % width) as f64, (k / width) as f64);
        let clipped: Vec<_> = (region.iter().filter(|k| self.is_clipped(**k)))
            .map(place)
            .collect();
        if clipped.is_empty() {
            return false;
        }
        let reach = 2.0 * (2.0 * variance_px2).sqrt() + 1.0;
        let is_beyond = |(x, y): (f64, f64)| {
            let mut near = clipped.iter();
            !near.any(|(a, b)| (x - a).powi(2) + (y - b).powi(2) <= reach * reach)
        };
        let beyond = region.par_iter().filter(|k| is_beyond(place(k))).count();
        beyond as f64 > MAX_BEYOND_CLIPPED * region.len() as f64
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
    signal_to_noise: f64,
}

/// Root mean squares over the samples where a light is strong.
struct Residual {
    /// Residual, in standard deviations.
    misfit: f64,
    /// Noise and texture without errors of the lens, in the same unit.
    noise_share: f64,
}

/// The variance of the picture around a light.
struct TextureVariance {
    mean: f64,
    /// That of the normal distribution whose squares have the median found.
    median: f64,
}

/// The texture of the picture, as far as the deviations of samples hold it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Texture {
    Unknown,
    Known,
}

/// The unknowns of a solved least-squares problem, and their misfit.
struct Minimum {
    unknowns: Vec<f64>,
    misfit: f64,
}

impl<'a> LightFit<'a> {
    fn new(
        inputs: &'a FitInputs<'a>,
        grid: &KernelGrid,
        window: RenderWindow,
        sources: &SourceLattice,
        samples: &[f32],
    ) -> Self {
        let width = inputs.size.0;
        let count = window.width * window.height;
        let mut columns: Vec<Column> = (sources.pixels.par_iter())
            .map(|pixel| grid.column((pixel % width, pixel / width), sources.spacing, window))
            .collect();
        let along = |at: usize, size: usize| (at as f32 + 0.5) / size as f32 - 0.5;
        let full = |value: &dyn Fn(usize) -> f32| {
            Column::full(window.width, (0..count).map(value).collect())
        };
        columns.push(full(&|_| 1.0));
        columns.push(full(&|k| along(k % window.width, window.width)));
        columns.push(full(&|k| along(k / window.width, window.height)));
        let pixels = || {
            (0..count)
                .map(|k| (window.row + k / window.width) * width + window.column + k % window.width)
        };
        Self {
            columns,
            width: window.width,
            source_count: sources.pixels.len(),
            neighbours: sources.neighbours(),
            samples: window.cut(width, samples),
            deviations: pixels().map(|pixel| inputs.deviation_at(pixel)).collect(),
            clipped: pixels().map(|pixel| inputs.is_clipped(pixel)).collect(),
            inputs,
        }
    }

    fn solve(mut self) -> std::result::Result<Solved, Fit> {
        let mut used: Vec<bool> = self.clipped.iter().map(|clipped| !clipped).collect();
        let mut minimum = self.minimise(&used, Texture::Unknown);
        // Texture is what remains far from the light.
        let texture = self.texture(&minimum.unknowns, &used);
        let most = MAX_TEXTURE_SHARE * self.brightest(&minimum.unknowns);
        if texture.mean.sqrt() > most {
            // Texture is everywhere; errors of the lens are next to the light.
            let is_everywhere = texture.median.sqrt() > 0.5 * most;
            return Err(if is_everywhere {
                Fit::Picture
            } else {
                Fit::Unexplained
            });
        }
        let texture = texture.mean;
        if texture.sqrt() > NEGLIGIBLE_TEXTURE * self.inputs.deviation {
            for deviation in &mut self.deviations {
                *deviation = (*deviation * *deviation + texture).sqrt();
            }
            minimum = self.minimise(&used, Texture::Known);
        }
        for _ in 1..CLIP_PASSES {
            if !self.is_measured(&minimum.unknowns) {
                return Err(Fit::Unexplained);
            }
            let model = self.model(&minimum.unknowns);
            let short = |k: usize| self.clipped[k] && !used[k] && model[k] < self.samples[k];
            let found: Vec<usize> = (0..used.len()).filter(|k| short(*k)).collect();
            if found.is_empty() {
                break;
            }
            for k in found {
                used[k] = true;
            }
            minimum = self.minimise(&used, Texture::Known);
        }
        let Minimum { unknowns, misfit } = minimum;
        let model_error = self.inputs.model_error * misfit.max(1.0);
        if model_error > MAX_MODEL_ERROR || !self.is_measured(&unknowns) {
            return Err(Fit::Unexplained);
        }
        let light: Vec<f32> = unknowns[..self.source_count]
            .iter()
            .map(|v| *v as f32)
            .collect();
        let blurred = self.model(&self.without_plane(&unknowns));
        Ok(Solved {
            blurred,
            model_error,
            signal_to_noise: self.signal_to_noise(&light, texture),
            light,
        })
    }

    /// Returns the mean of the sources that have `light` over the standard deviation of the light of one alone, where the
    /// picture has `texture`, a variance.
    fn signal_to_noise(&self, light: &[f32], texture: f64) -> f64 {
        let lit = light.iter().filter(|v| **v > 0.0);
        let (sum, count) = lit.fold((0.0, 0_usize), |(sum, count), v| {
            (sum + f64::from(*v), count + 1)
        });
        let columns = &self.columns[..self.source_count];
        let squares = columns.iter().map(Column::square_sum).sum::<f64>() / columns.len() as f64;
        let deviation = self.inputs.deviation.hypot(texture.sqrt());
        sum / count.max(1) as f64 * squares.sqrt() / deviation
    }

    /// Returns whether enough of the light falls on samples that are not clipped.
    fn is_measured(&self, unknowns: &[f64]) -> bool {
        let light = self.model(&self.without_plane(unknowns));
        let all = light.iter().map(|v| f64::from(*v)).sum::<f64>();
        let measured = light
            .iter()
            .zip(&self.clipped)
            .filter(|(_, clipped)| !**clipped);
        measured.map(|(v, _)| f64::from(*v)).sum::<f64>() >= MIN_MEASURED_SHARE * all
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
    fn texture(&self, unknowns: &[f64], used: &[bool]) -> TextureVariance {
        let light = self.model(&self.without_plane(unknowns));
        let model = self.model(unknowns);
        let is_weak = |k: &usize| {
            let sample = f64::from(self.samples[*k]);
            used[*k] && f64::from(light[*k]) < self.deviations[*k].max(0.1 * sample)
        };
        let weak: Vec<usize> = (0..self.samples.len()).filter(is_weak).collect();
        let model = &model;
        let excess = |share: f64| {
            weak.iter().map(move |k| {
                let square = f64::from(self.samples[*k] - model[*k]).powi(2);
                square / share - self.deviations[*k].powi(2)
            })
        };
        let count = weak.len();
        let mean = excess(1.0).sum::<f64>() / (count as f64).max(1.0);
        let mut all: Vec<f64> = excess(MEDIAN_SQUARE_NORMAL).collect();
        let median = if all.is_empty() {
            0.0
        } else {
            *all.select_nth_unstable_by(count / 2, f64::total_cmp).1
        };
        TextureVariance {
            mean: mean.max(0.0),
            median: median.max(0.0),
        }
    }

    /// Lowers the weight of the total variation until the residual of the `used` samples is that of the noise.
    ///
    /// While the texture is unknown it stops as soon as that is too large, and does not shrink any more.
    fn minimise(&self, used: &[bool], texture: Texture) -> Minimum {
        let (columns, width) = (&self.columns, self.width);
        let mut equations = Equations::new(columns, width, &self.samples, &self.deviations, used);
        equations.refresh();
        let steepest = (0..self.source_count)
            .map(|j| equations.descent(j))
            .fold(0.0, f64::max);
        let mut weight = steepest / WEIGHT_STEP;
        let mut misfit = f64::INFINITY;
        let (mut texture_variance, mut brightest) = (f64::INFINITY, 0.0);
        for tried in 0..WEIGHTS {
            for _ in 0..REWEIGHTINGS {
                self.descend(&mut equations, weight);
            }
            let previous = misfit;
            let residual = self.residual(&equations.unknowns, used);
            misfit = residual.misfit;
            let is_noise = misfit < WANTED_MISFIT * residual.noise_share;
            let is_plateau = misfit < WANTED_MISFIT && misfit > PLATEAU * previous;
            if is_noise || is_plateau {
                break;
            }
            if texture == Texture::Unknown && tried >= WEIGHTS_FOR_TEXTURE {
                let (before, dimmer) = (texture_variance, brightest);
                texture_variance = self.texture(&equations.unknowns, used).mean;
                brightest = self.brightest(&equations.unknowns);
                let has_grown = brightest < dimmer / TEXTURE_PLATEAU;
                let most = (MAX_TEXTURE_SHARE * brightest).powi(2);
                if has_grown && texture_variance > most.max(TEXTURE_PLATEAU * before) {
                    break;
                }
            }
            weight /= WEIGHT_STEP;
        }
        Minimum {
            unknowns: equations.unknowns,
            misfit,
        }
    }

    /// Compares samples and model where the light is strong.
    fn residual(&self, unknowns: &[f64], used: &[bool]) -> Residual {
        let light = self.model(&self.without_plane(unknowns));
        let model = self.model(unknowns);
        let lens_error = |k: usize| self.inputs.model_error * f64::from(self.samples[k]);
        let (mut sum, mut noise_sum, mut count) = (0.0, 0.0, 0.0_f64);
        for k in 0..self.samples.len() {
            let deviation = self.deviations[k];
            if used[k] && f64::from(light[k]) > deviation {
                sum += (f64::from(self.samples[k] - model[k]) / deviation).powi(2);
                noise_sum += 1.0 - (lens_error(k) / deviation).powi(2);
                count += 1.0;
            }
        }
        Residual {
            misfit: (sum / count.max(1.0)).sqrt(),
            noise_share: (noise_sum / count.max(1.0)).sqrt(),
        }
    }

    /// Sweeps over the unknowns, with the total variation weighted quadratically around the present sources.
    fn descend(&self, equations: &mut Equations, weight: f64) {
        let unknowns = &equations.unknowns;
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
        equations.refresh();
        for _ in 0..SWEEPS {
            for j in 0..equations.unknowns.len() {
                let (mut gradient, mut curvature) = (equations.descent(j), equations.curvature(j));
                let unknowns = &equations.unknowns;
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
                equations.set(j, value);
            }
        }
    }
}
