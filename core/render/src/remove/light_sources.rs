//! Bright lights of a plate as sources of their own, estimated before the rest of the picture.
//!
//! Deconvolution with a prior for pictures rings about lights: they are brighter than anything the prior expects, and an
//! error of a thousandth in their light is more than the picture beside them. So lights are fitted one by one
//! (`light_fit`), taken off the plate, and added again to the sharp picture. What the errors of the lens leave of them in
//! the plate counts as noise.

use super::light_candidates::CandidateSearch;
use super::light_fit::{Fit, FitInputs, FittedLight};
use super::{Canvas, Highlights};
use crate::{LocalKernels, RenderWindow, Scene, VergencePass};
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// Times that each light is fitted, with the others taken off the plate.
const PASSES: usize = 2;
/// Largest number of pixels of a region that is tried.
const MAX_REGION: usize = 20_000;
/// Largest number of lights, for each thousand pixels of the plate.
const MAX_LIGHTS_PER_THOUSAND: usize = 1;
/// Largest number of multiplications that the fits may take, for each pixel of the plate.
const WORK_PER_PIXEL: f64 = 2e4;

/// Ratio of the brightest to the dimmest sample of a region from which it would ring as a part of the picture.
const RINGING_CONTRAST: f32 = 3.0;

/// Least range of the samples of a bright region, standard deviations of a typical sample.
const STANDING_OUT_DEVIATIONS: f64 = 100.0;

/// Least signal-to-noise ratio of the sources of a light that is separated. Those of a large light before a textured picture
/// are not determined: they take a part of the picture with them, and what is left of it rings.
const LEAST_SIGNAL_TO_NOISE: f64 = 10.0;

/// Reach of the errors of a light, px.
const ERROR_REACH: usize = 2;

/// The lights of a plane of a plate.
#[derive(Debug, Clone)]
pub(super) struct LightSources {
    /// The pixels of the plate that are sources, and their light.
    pub(super) sources: Vec<(usize, f32)>,
    /// The light that sources bring to each pixel of the plate.
    pub(super) blurred: Vec<f32>,
    /// Standard deviation of the errors of that light.
    pub(super) error: Vec<f32>,
    /// Whether a pixel belongs to a light that is explained.
    pub(super) explained: Vec<bool>,
    /// Whether a pixel belongs to a light that keeps its blur, as the lens does not explain it in all colours.
    pub(super) unexplained: Vec<bool>,
}

impl LightSources {
    /// Returns those of a plate of `count` pixels without lights.
    pub(super) fn none(count: usize) -> Self {
        Self {
            sources: Vec::new(),
            blurred: vec![0.0; count],
            error: vec![0.0; count],
            explained: vec![false; count],
            unexplained: vec![false; count],
        }
    }

    /// Returns the samples of the plate without the light of the sources.
    pub(super) fn taken_off(&self, samples: &[f32]) -> Vec<f32> {
        samples
            .iter()
            .zip(&self.blurred)
            .map(|(v, light)| v - light)
            .collect()
    }

    /// Adds the sources to `sharp`, a plane of `canvas`.
    pub(super) fn add_sources(&self, sharp: &mut [f32], canvas: &Canvas) {
        let width = canvas.size().0;
        for (pixel, light) in &self.sources {
            let (x, y) = (pixel % canvas.plate.0, pixel / canvas.plate.0);
            sharp[(y + canvas.margin_y) * width + x + canvas.margin_x] += light;
        }
    }
}

/// The lights that a search found in one plane.
pub(super) struct FoundLights {
    /// Those that are explained: the pixels of the plate that show them, and their sources.
    lights: Vec<(Vec<usize>, FittedLight)>,
    /// Whether a pixel belongs to a light that keeps its blur.
    kept: Vec<bool>,
}

impl FoundLights {
    /// Returns those of a plate of `count` pixels without lights.
    pub(super) fn none(count: usize) -> Self {
        Self {
            lights: Vec::new(),
            kept: vec![false; count],
        }
    }

    /// Lets lights that keep their blur in one of the `planes` keep it in all: a lamp that is sharp in two colours
    /// gets a rim of the third.
    pub(super) fn agree<'a>(planes: impl Iterator<Item = &'a mut Self>) {
        let mut planes: Vec<&mut Self> = planes.collect();
        let count = planes.first().map_or(0, |plane| plane.kept.len());
        let mut agreed = false;
        while !agreed {
            let kept = |pixel: usize| planes.iter().any(|plane| plane.kept[pixel]);
            let kept: Vec<bool> = (0..count).map(kept).collect();
            agreed = true;
            for plane in &mut planes {
                agreed &= plane.keep_blur_of(&kept) == 0;
            }
        }
    }

    /// Lets these `pixels`, and all lights that they show, keep their blur. Returns the number of lights that were
    /// explained before.
    pub(super) fn keep_blur_of(&mut self, pixels: &[bool]) -> usize {
        for (kept, pixel) in self.kept.iter_mut().zip(pixels) {
            *kept |= pixel;
        }
        let count = self.lights.len();
        let kept = &mut self.kept;
        self.lights.retain(|(region, _)| {
            let shows = region.iter().any(|pixel| pixels[*pixel]);
            if shows {
                region.iter().for_each(|pixel| kept[*pixel] = true);
            }
            !shows
        });
        count - self.lights.len()
    }

    /// Makes lights without any of these `pixels` a part of the picture.
    pub(super) fn retain_lights_of(&mut self, pixels: &[bool]) {
        (self.lights).retain(|(region, _)| region.iter().any(|pixel| pixels[*pixel]));
    }

    /// The light of all sources, on a plate `width` pixels wide.
    pub(super) fn sources(self, width: usize) -> LightSources {
        let mut found = LightSources::none(self.kept.len());
        for (region, light) in self.lights {
            add(&mut found.blurred, width, &light, 1.0);
            light.add_error(&mut found.error, width);
            for pixel in region {
                found.explained[pixel] = true;
            }
            found.sources.extend(light.sources);
        }
        found.unexplained = self.kept;
        found
    }
}

/// A plate that is searched for lights.
pub(super) struct LightSearch<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) samples: &'a [f32],
    pub(super) weights: &'a [f64],
    /// Standard deviation of a typical sample.
    pub(super) deviation: f64,
    /// Relative error of the lens.
    pub(super) model_error: f64,
    pub(super) highlights: &'a Highlights,
    pub(super) clip_level: Option<f32>,
}

impl LightSearch<'_> {
    /// Fits the lights of the plate.
    ///
    /// # Errors
    /// A lens that cannot be drawn; cancellation by `progress`.
    pub(super) fn run(&self, progress: &Progress) -> Result<FoundLights> {
        let count = self.samples.len();
        let mut found = FoundLights::none(count);
        let (reach_x, reach_y) = self.scene.reach_px();
        let search = CandidateSearch {
            samples: self.samples,
            width: self.scene.width,
            deviation: self.deviation as f32,
            reach: reach_x.max(reach_y) as usize,
        };
        let is_clipped = |k: usize| {
            self.clip_level
                .is_some_and(|level| self.samples[k] >= level)
        };
        let bright = |k: usize| is_clipped(k) || self.highlights.excess(k) > 0.0;
        let mut regions = search.regions(bright);
        // Light from beyond the plate's edges is unknown, and with it the rest of a light that touches them.
        let (width, height) = (self.scene.width, self.scene.height);
        let is_inside = |k: &usize| {
            (1..width - 1).contains(&(k % width)) && (1..height - 1).contains(&(k / width))
        };
        regions.retain(|region| region.len() <= MAX_REGION && region.iter().all(is_inside));
        // The brightest come first: they disturb the others most.
        let peak = |region: &[usize]| {
            region
                .iter()
                .fold(0.0_f32, |most, k| most.max(self.samples[*k]))
        };
        regions.sort_by(|a, b| peak(b).total_cmp(&peak(a)));
        regions.truncate((count * MAX_LIGHTS_PER_THOUSAND).div_ceil(1000));
        let mut lights: Vec<Option<FittedLight>> = regions.iter().map(|_| None).collect();
        let mut rest = self.samples.to_vec();
        let mut budget = WORK_PER_PIXEL * count as f64;
        let steps = (PASSES * regions.len()) as f64;
        for pass in 0..PASSES {
            for (index, region) in regions.iter().enumerate() {
                if !progress((pass * regions.len() + index) as f64 / steps) {
                    return Err(crate::cancelled());
                }
                if pass > 0 && !overlaps_others(&lights, index) {
                    continue;
                }
                if let Some(light) = lights[index].take() {
                    add(&mut rest, self.scene.width, &light, 1.0);
                }
                let fit = self.fit(region, &rest, &mut budget)?;
                if let Fit::Light(light) = fit {
                    add(&mut rest, self.scene.width, &light, -1.0);
                    lights[index] = Some(light);
                } else if matches!(fit, Fit::Unexplained) && self.would_ring(region) {
                    region.iter().for_each(|pixel| found.kept[*pixel] = true);
                }
            }
        }
        let keeps_blur = |region: &[usize]| {
            region.iter().any(|k| is_clipped(*k))
                || self.stands_out(region) && region.iter().any(|k| bright(*k))
        };
        for (region, light) in regions.into_iter().zip(lights) {
            let was_fitted = light.is_some();
            match light.filter(|light| light.signal_to_noise >= LEAST_SIGNAL_TO_NOISE) {
                Some(light) => found.lights.push((region, light)),
                None if keeps_blur(&region) || was_fitted && self.would_ring(&region) => {
                    region.iter().for_each(|pixel| found.kept[*pixel] = true);
                }
                None => {}
            }
        }
        Ok(found)
    }

    /// Returns whether a region that is a highlight in one of the colours is bright in this one.
    fn stands_out(&self, region: &[usize]) -> bool {
        let (dimmest, brightest) = self.range(region);
        self.would_ring(region)
            && f64::from(brightest - dimmest) > STANDING_OUT_DEVIATIONS * self.deviation
    }

    /// Returns the dimmest and the brightest sample of a region.
    fn range(&self, region: &[usize]) -> (f32, f32) {
        let light = region.iter().map(|k| self.samples[*k]);
        light.fold((f32::INFINITY, 0.0_f32), |(low, high), v| {
            (low.min(v), high.max(v))
        })
    }

    /// Returns whether a region that is no explained light would ring as a part of the picture: its contrast is high.
    fn would_ring(&self, region: &[usize]) -> bool {
        let (dimmest, brightest) = self.range(region);
        brightest > RINGING_CONTRAST * dimmest
    }

    /// Fits one light.
    fn fit(&self, region: &[usize], samples: &[f32], budget: &mut f64) -> Result<Fit> {
        let scene = self.at_depth_of(region);
        let kernels = LocalKernels::new(&scene, self.weights)?;
        let inputs = FitInputs {
            kernels: &kernels,
            plate: self.samples,
            size: (scene.width, scene.height),
            deviation: self.deviation,
            model_error: self.model_error,
            clip_level: self.clip_level,
        };
        inputs.fit(region, samples, budget)
    }

    /// Returns the scene with the depth of a region's brightest pixel everywhere.
    fn at_depth_of(&self, region: &[usize]) -> Scene<'_> {
        let brightest = region
            .iter()
            .max_by(|a, b| self.samples[**a].total_cmp(&self.samples[**b]));
        let vergence = self.scene.vergence_at(brightest.copied().unwrap_or(0));
        Scene {
            vergence: VergencePass::Constant(vergence),
            ..*self.scene
        }
    }
}

impl FittedLight {
    /// Adds the standard deviation of the errors of the light to `plane`, `width` samples wide: a share of the most light
    /// near a pixel, since errors of a kernel's width are larger than that share of its steep tails.
    fn add_error(&self, plane: &mut [f32], width: usize) {
        let RenderWindow {
            column,
            row,
            width: columns,
            height: rows,
        } = self.window;
        let near = |at: usize, count: usize| {
            at.saturating_sub(ERROR_REACH)..(at + ERROR_REACH + 1).min(count)
        };
        let along_rows: Vec<f32> = (0..columns * rows)
            .map(|k| {
                let row = &self.blurred[k / columns * columns..][..columns];
                row[near(k % columns, columns)]
                    .iter()
                    .fold(0.0_f32, |most, v| most.max(*v))
            })
            .collect();
        for y in 0..rows {
            for x in 0..columns {
                let most =
                    near(y, rows).fold(0.0_f32, |most, y| most.max(along_rows[y * columns + x]));
                plane[(row + y) * width + column + x] += self.model_error as f32 * most;
            }
        }
    }
}

/// Returns whether the light at `index` was fitted and shares a part of the plate with another.
fn overlaps_others(lights: &[Option<FittedLight>], index: usize) -> bool {
    let Some(light) = &lights[index] else {
        return false;
    };
    let overlap =
        |a: usize, a_size: usize, b: usize, b_size: usize| a < b + b_size && b < a + a_size;
    let others = lights.iter().enumerate().filter(|(k, _)| *k != index);
    others.filter_map(|(_, other)| other.as_ref()).any(|other| {
        let (a, b) = (&light.window, &other.window);
        overlap(a.column, a.width, b.column, b.width) && overlap(a.row, a.height, b.row, b.height)
    })
}

/// Adds `gain` times the blurred `light` to `plane`, `width` samples wide.
fn add(plane: &mut [f32], width: usize, light: &FittedLight, gain: f32) {
    let RenderWindow {
        column,
        row,
        width: columns,
        ..
    } = light.window;
    for (y, samples) in light.blurred.chunks_exact(columns.max(1)).enumerate() {
        let out = &mut plane[(row + y) * width + column..];
        for (out, sample) in out.iter_mut().zip(samples) {
            *out += gain * sample;
        }
    }
}
