//! The deconvolution of planes: what each plane keeps of its blur, the problem that is solved, and its result.

use super::admm::solve;
use super::hole_filling::fill_holes;
use super::kept_blur::{KeptBlur, KeptBlurReason};
use super::lens_operator::LensOperator;
use super::light_sources::FoundLights;
use super::noise_model::NoiseModel;
use super::problem::{Problem, Refinement};
use super::separation::{PlaneLights, PlateInputs};
use super::{Canvas, Highlights, Saturation, darkest_sample};
use crate::{Plane, Scene};
use rayon::prelude::*;
use seidel_optics::Progress;
use seidel_optics::error::{Error, Result};

/// Relative error of lens and operator: it counts as noise.
pub(super) const MODEL_ERROR: f64 = 2e-3;
/// Relative error of the operator alone, which counts as noise in the picture around the lights. That of the lens is found as a
/// residual. Kernels of one pixel are drawn to about 1e-3, larger ones better.
const PICTURE_ERROR: f64 = 1e-3;
/// Share of the progress taken by the search for lights.
pub(super) const LIGHTS_SHARE: f64 = 0.2;
/// Noise that is assumed, over the estimate: noise taken for detail is amplified, while too much assumed noise costs little
/// detail.
const ASSUMED_NOISE: f64 = 1.1;
/// Largest error of the light of separated sources with which a sample is used, in standard deviations of a typical
/// sample. Unlike noise the error has one sign over many samples: larger ones darken the ground about faint lights.
const LARGEST_LIGHT_ERROR: f64 = 0.7;

/// Removes blur from planes by total-variation deconvolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deconvolver {
    /// Standard deviation of the planes' noise, in their own units; `None` estimates it from each plane.
    pub noise: Option<f64>,
    /// The rule by which clipped samples are found.
    pub saturation: Saturation,
    /// Least number of ADMM iterations. Up to four times as many run until the residual is that of the noise.
    pub iterations: usize,
    /// The treatment of bright lights.
    pub lights: Lights,
}

/// The treatment of lights that are much brighter than their surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Lights {
    /// Sources of their own, estimated before the rest of the picture. Those that the lens does not explain keep their
    /// blur.
    #[default]
    Separate,
    /// A part of the picture; highlights and clipped samples keep their blur.
    KeepBlur,
}

impl Default for Deconvolver {
    /// Ten iterations at least.
    fn default() -> Self {
        Self {
            noise: None,
            saturation: Saturation::Auto,
            iterations: 10,
            lights: Lights::Separate,
        }
    }
}

/// A plane without its blur.
#[derive(Debug, Clone, PartialEq)]
pub struct SharpPlane {
    /// The place of the plate on the canvas.
    pub canvas: Canvas,
    /// The sharp image on the whole canvas, row-major. Clipped samples, highlights, and pixels that get their light keep
    /// their blur. The margin is the light that is blurred into the plate from beyond its edges.
    pub sharp: Vec<f32>,
    /// The residual on the plate: the plane minus the blurred `sharp`, row-major. It holds noise and what the lens does not
    /// explain, and is 0 where pixels keep their blur.
    pub residual: Vec<f32>,
    /// Standard deviation of the plane's noise, as given or as estimated.
    pub noise: f64,
    /// The clipped samples of the plane; `None` if it is not clipped.
    pub clipping: Option<Clipping>,
    /// Root mean square residual in standard deviations of noise and model error. Well above 1, the lens does not explain
    /// the plate. Bright lights have small weights.
    pub misfit: f64,
    /// Share of the detail at each pixel of the plate, over all frequencies up to Nyquist, that the plate determines and not
    /// the regularisation: 0 to 1, and 0 where pixels keep their blur.
    pub confidence: Vec<f32>,
    /// The pixels of the plate that keep their blur.
    pub kept: KeptBlur,
}

/// The clipped samples of a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clipping {
    /// Samples at this level and above are clipped.
    pub level: f64,
    /// Number of clipped samples.
    pub count: usize,
}

impl SharpPlane {
    /// Returns the grain of the plate on the canvas: the residual, limited to three standard deviations of the noise and
    /// mirrored into the margin. Added to `sharp` it gives the sharp image the plate's own grain.
    pub fn grain(&self) -> Vec<f32> {
        let most = (3.0 * self.noise) as f32;
        let residual = self.residual.par_iter();
        let grain: Vec<f32> = residual.map(|v| v.clamp(-most, most)).collect();
        self.canvas.extend_by_mirroring(&grain)
    }
}

/// The settings in which removal and the check of a lens differ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Variant {
    /// Relative error of lens and operator for lights.
    pub(super) model_error: f64,
    /// The same for the picture around them.
    pub(super) picture_error: f64,
    pub(super) refinement: Refinement,
    pub(super) lights: Lights,
}

impl Variant {
    /// The variant that removes blur from a plate.
    pub(super) fn removal(lights: Lights) -> Self {
        Self {
            model_error: MODEL_ERROR,
            picture_error: PICTURE_ERROR,
            refinement: Refinement::Run,
            lights,
        }
    }
}

/// Finds the lights of the colour `planes` of a plate, each with the settings of its removal. A light that the lens does not explain
/// in one of them is separated in none.
///
/// # Errors
/// Those of [`Deconvolver::remove`].
pub fn find_lights(
    scene: &Scene,
    planes: &[(Deconvolver, Plane)],
    progress: &Progress,
) -> Result<Vec<PlaneLights>> {
    let all: Vec<Plane> = planes.iter().map(|(_, plane)| *plane).collect();
    scene.check(&all)?;
    let highlights = Highlights::detect(&all, scene.width);
    let mut searched = Vec::with_capacity(planes.len());
    for (deconvolver, plane) in planes {
        deconvolver.check()?;
        let done = searched.len() as f64;
        let progress = |share: f64| progress((done + share) / planes.len() as f64);
        let variant = Variant::removal(deconvolver.lights);
        let plate = PlateInputs::new(scene, &highlights, variant);
        searched.push(plate.search(deconvolver, plane, &progress)?);
    }
    FoundLights::agree(searched.iter_mut().map(|plane| &mut plane.found));
    let lights = searched.into_iter();
    Ok(lights
        .map(|plane| plane.lights(&highlights, scene.width))
        .collect())
}

impl Deconvolver {
    /// Removes the blur of `scene` from `planes`. Highlights of any plane keep their blur in all, as do lights that the
    /// lens does not explain in one. The result is the same to the bit for any number of threads.
    ///
    /// A vergence that varies is that of the sharp image. The boundary condition of `scene` is ignored, because the light
    /// around the plate is estimated as well. `progress` gets the share done.
    ///
    /// # Errors
    /// An invalid scene, planes, noise or clipping level; a lens that cannot be drawn; cancellation by `progress`.
    pub fn remove(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &Progress,
    ) -> Result<Vec<SharpPlane>> {
        let finding = |share: f64| progress(LIGHTS_SHARE * share);
        let own: Vec<_> = planes.iter().map(|plane| (*self, *plane)).collect();
        let lights = find_lights(scene, &own, &finding)?;
        let step = (1.0 - LIGHTS_SHARE) / planes.len().max(1) as f64;
        let planes = planes.iter().zip(&lights).enumerate();
        planes
            .map(|(done, (plane, lights))| {
                let progress = |share: f64| progress(LIGHTS_SHARE + step * (done as f64 + share));
                self.remove_around(lights, scene, plane, &progress)
            })
            .collect()
    }

    /// Removes blur like [`Deconvolver::remove`] from one of the planes whose `lights` were found by [`find_lights`].
    ///
    /// # Errors
    /// Those of [`Deconvolver::remove`].
    pub fn remove_around(
        &self,
        lights: &PlaneLights,
        scene: &Scene,
        plane: &Plane,
        progress: &Progress,
    ) -> Result<SharpPlane> {
        scene.check(&[*plane])?;
        self.check()?;
        let variant = Variant::removal(self.lights);
        let plate = PlateInputs::new(scene, &lights.highlights, variant);
        self.remove_from_plane(&plate, plane, lights, progress)
    }

    /// Removes blur like [`Deconvolver::remove`], from one plane in a variant of the method.
    pub(super) fn remove_variant(
        &self,
        variant: Variant,
        scene: &Scene,
        plane: &Plane,
        progress: &Progress,
    ) -> Result<SharpPlane> {
        scene.check(&[*plane])?;
        self.check()?;
        let highlights = Highlights::detect(&[*plane], scene.width);
        let plate = PlateInputs::new(scene, &highlights, variant);
        let searched = plate.search(self, plane, &|share| progress(LIGHTS_SHARE * share))?;
        let lights = searched.lights(&highlights, scene.width);
        let progress = |share: f64| progress(LIGHTS_SHARE + (1.0 - LIGHTS_SHARE) * share);
        self.remove_from_plane(&plate, plane, &lights, &progress)
    }

    pub(super) fn check(&self) -> Result<()> {
        if let Some(noise) = self.noise
            && !(noise.is_finite() && noise >= 0.0)
        {
            return Err(Error::new(
                "noise",
                format!("is {noise}"),
                "give a standard deviation of zero or more",
            ));
        }
        if let Saturation::Level(level) = self.saturation
            && !level.is_finite()
        {
            return Err(Error::new(
                "saturation",
                format!("is {level}"),
                "give the level at which samples are clipped",
            ));
        }
        Ok(())
    }

    fn remove_from_plane(
        &self,
        plate: &PlateInputs,
        plane: &Plane,
        lights: &PlaneLights,
        progress: &Progress,
    ) -> Result<SharpPlane> {
        if is_uniform(plane.samples) {
            return Ok(self.uniform_plane(plate, plane));
        }
        let canvas = plate.canvas;
        let operator = &LensOperator::new(plate.scene, &canvas, plane.weights)?;
        let mut kept = plate.kept_blur(plane.samples, lights, operator)?;
        let PlaneLights {
            noise,
            least_noise,
            deviation,
            clip_level,
            sources: ref lights,
            ..
        } = *lights;
        let rest = &lights.taken_off(plane.samples);
        let is_clipped = |k: usize| clip_level.is_some_and(|level| plane.samples[k] >= level);
        let known: Vec<bool> = (kept.shares().enumerate())
            .map(|(k, kept)| {
                let is_lost = f64::from(lights.error[k]) > LARGEST_LIGHT_ERROR * deviation;
                kept == 0.0 && !is_lost && !(lights.explained[k] && is_clipped(k))
            })
            .collect();
        let filled = fill_holes(rest, plate.scene.width, &known);
        let extended = canvas.extend_by_mirroring(&filled);
        let assumed = self.noise.unwrap_or(ASSUMED_NOISE * noise);
        let noise_model = NoiseModel::new(&extended, assumed, plate.variant.picture_error);
        let errors = canvas.embed(0.0, |k| lights.error[k]);
        let mut weights =
            noise_model.weights(&extended, &errors, &canvas.embed(false, |k| known[k]));
        for (k, weight) in weights.iter_mut().enumerate() {
            if operator.is_at_edge(k) {
                *weight = 0.0;
            }
        }
        let mut problem = Problem {
            plate: &extended,
            canvas,
            operator,
            weights,
            noise: assumed,
            least_noise,
            deviation: noise_model.deviation(),
            iterations: self.iterations,
            refinement: plate.variant.refinement,
        };
        let solution = solve(&mut problem, progress)?;
        let residual = problem.residual(&solution.estimate);
        let misfit = problem.misfit(&solution.estimate);
        let unexplained = match plate.variant.refinement {
            Refinement::Run => canvas.crop(&problem.unexplained_shares(&solution.estimate)?),
            Refinement::Skip => Vec::new(),
        };
        let mut sharp = solution.estimate.image;
        // Without what is hidden.
        sharp.truncate(extended.len());
        lights.add_sources(&mut sharp, &canvas);
        // Light is not negative; noise about black is.
        let darkest = darkest_sample(plane.samples);
        sharp
            .par_iter_mut()
            .for_each(|sample| *sample = sample.max(darkest));
        for (k, share) in unexplained.iter().enumerate() {
            kept.keep(k, *share, KeptBlurReason::UnexplainedPicture);
        }
        let shares: Vec<f32> = kept.shares().collect();
        let kept_pixels = canvas.embed(None, |k| (shares[k] > 0.0).then_some(k));
        for (sample, kept_pixel) in sharp.iter_mut().zip(kept_pixels) {
            if let Some(k) = kept_pixel {
                *sample += shares[k] * (plane.samples[k] - *sample);
            }
        }
        let data_share = operator.mean_over_frequencies(|h, gradient_power| {
            solution.quadratic.data_share(h, gradient_power)
        })?;
        let data_share = canvas.crop(&data_share);
        let is_determined = shares.iter().zip(&known);
        let confidence = data_share.iter().zip(is_determined);
        Ok(SharpPlane {
            canvas,
            sharp,
            residual,
            noise,
            clipping: clip_level.map(|level| Clipping {
                level: f64::from(level),
                count: plane.samples.iter().filter(|v| **v >= level).count(),
            }),
            misfit,
            confidence: confidence
                .map(|(share, (kept, known))| {
                    if *known {
                        share.clamp(0.0, 1.0) * (1.0 - kept)
                    } else {
                        0.0
                    }
                })
                .collect(),
            kept,
        })
    }

    /// Returns a plane of one level as it is, so that opaque alpha stays opaque.
    fn uniform_plane(&self, plate: &PlateInputs, plane: &Plane) -> SharpPlane {
        let count = plane.samples.len();
        SharpPlane {
            canvas: plate.canvas,
            sharp: plate.canvas.extend_by_replication(plane.samples),
            residual: vec![0.0; count],
            noise: self.noise.unwrap_or(0.0),
            clipping: None,
            misfit: 0.0,
            confidence: vec![1.0; count],
            kept: KeptBlur::none(count),
        }
    }
}

/// Returns whether all samples are equal.
pub(super) fn is_uniform(samples: &[f32]) -> bool {
    samples.windows(2).all(|pair| pair[0] == pair[1])
}
