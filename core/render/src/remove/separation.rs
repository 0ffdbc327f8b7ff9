//! Separation of a plane: its lights, the rest of its picture, and what keeps its blur.

use super::deconvolver::{Lights, Variant, is_uniform};
use super::kept_blur::{KeptBlur, KeptBlurReason};
use super::lens_operator::LensOperator;
use super::light_sources::{FoundLights, LightSearch, LightSources};
use super::noise_estimate::estimate_noise;
use super::noise_model::NoiseModel;
use super::{Canvas, Deconvolver, Highlights, ramp};
use crate::{Plane, Scene};
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// Light from clipped samples and highlights, in units of the highlight threshold, at which a pixel begins to keep its
/// blur and keeps all of it.
const KEPT_HIGHLIGHT_LIGHT: [f32; 2] = [0.003, 0.02];

/// The inputs that all planes of a plate have in common.
pub(super) struct PlateInputs<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) canvas: Canvas,
    pub(super) highlights: &'a Highlights,
    pub(super) variant: Variant,
}

/// The lights of a plane of a plate, as [`find_lights`](super::find_lights) returns them.
#[derive(Debug, Clone)]
pub struct PlaneLights {
    pub(super) highlights: Highlights,
    /// Standard deviation of the noise.
    pub(super) noise: f64,
    /// The least that it can be.
    pub(super) least_noise: f64,
    /// Standard deviation of a typical sample: noise and model error.
    pub(super) deviation: f64,
    pub(super) clip_level: Option<f32>,
    pub(super) sources: LightSources,
}

/// A search for the lights of a plane: what is known of its samples, and what was found.
pub(super) struct SearchedPlane {
    noise: f64,
    least_noise: f64,
    deviation: f64,
    clip_level: Option<f32>,
    pub(super) found: FoundLights,
}

impl SearchedPlane {
    /// The lights that are left, on a plate `width` pixels wide.
    pub(super) fn lights(self, highlights: &Highlights, width: usize) -> PlaneLights {
        PlaneLights {
            highlights: highlights.clone(),
            noise: self.noise,
            least_noise: self.least_noise,
            deviation: self.deviation,
            clip_level: self.clip_level,
            sources: self.found.sources(width),
        }
    }
}

impl<'a> PlateInputs<'a> {
    pub(super) fn new(scene: &'a Scene<'a>, highlights: &'a Highlights, variant: Variant) -> Self {
        Self {
            scene,
            canvas: Canvas::new(scene),
            highlights,
            variant,
        }
    }

    /// Searches `plane` for lights.
    ///
    /// # Errors
    /// A lens that cannot be drawn; cancellation by `progress`.
    pub(super) fn search(
        &self,
        deconvolver: &Deconvolver,
        plane: &Plane,
        progress: &Progress,
    ) -> Result<SearchedPlane> {
        if is_uniform(plane.samples) {
            return Ok(SearchedPlane {
                noise: 0.0,
                least_noise: 0.0,
                deviation: 0.0,
                clip_level: None,
                found: FoundLights::none(plane.samples.len()),
            });
        }
        let canvas = self.canvas;
        let estimate = estimate_noise(self.scene, plane)?;
        let noise = deconvolver.noise.unwrap_or(estimate.deviation);
        let clip_level = deconvolver.saturation.level(plane.samples, noise);
        let model_error = self.variant.model_error;
        let mirrored = canvas.extend_by_mirroring(plane.samples);
        let deviation = NoiseModel::new(&mirrored, noise, model_error).deviation();
        let found = match self.variant.lights {
            Lights::KeepBlur => FoundLights::none(plane.samples.len()),
            Lights::Separate => LightSearch {
                scene: self.scene,
                samples: plane.samples,
                weights: plane.weights,
                deviation,
                model_error,
                highlights: self.highlights,
                clip_level,
            }
            .run(progress)?,
        };
        Ok(SearchedPlane {
            noise,
            least_noise: estimate.least(noise),
            deviation,
            clip_level,
            found,
        })
    }

    /// Returns the blur that the pixels of the plate keep. Explained lights keep none.
    ///
    /// Clipped samples are lower bounds of the light, so sharpening the pixels that get their light makes these ring.
    /// Highlights and lights that the lens does not explain are treated like them. At depth edges part of the light is hidden.
    pub(super) fn kept_blur(
        &self,
        samples: &[f32],
        lights: &PlaneLights,
        operator: &LensOperator,
    ) -> Result<KeptBlur> {
        let (clip_level, lights) = (lights.clip_level, &lights.sources);
        let count = self.canvas.plate_pixel_count();
        let mut kept = KeptBlur::none(count);
        let reason = |k: usize| {
            if lights.explained[k] {
                None
            } else if clip_level.is_some_and(|level| samples[k] >= level) {
                Some(KeptBlurReason::Clipped)
            } else if lights.unexplained[k] {
                Some(KeptBlurReason::UnexplainedLight)
            } else {
                (self.highlights.excess(k) > 0.0).then_some(KeptBlurReason::Highlight)
            }
        };
        let reasons: Vec<_> = (0..count).map(reason).collect();
        if reasons.iter().all(Option::is_none) {
            return Ok(kept);
        }
        // In units of the highlight threshold; clipped samples count as one at least.
        let excess = |k: usize| match reasons[k] {
            None => 0.0,
            Some(KeptBlurReason::Highlight) => self.highlights.excess(k),
            Some(_) => self.highlights.excess(k).max(1.0),
        };
        let blurred = operator.apply(&self.canvas.embed(0.0, excess))?;
        for (k, light) in self.canvas.crop(&blurred).iter().enumerate() {
            match reasons[k] {
                Some(reason) => kept.keep(k, 1.0, reason),
                None => {
                    let share = ramp(*light, KEPT_HIGHLIGHT_LIGHT);
                    kept.keep(k, share, KeptBlurReason::NearLight);
                }
            }
        }
        Ok(kept)
    }
}
