//! Separation of a plane: its lights, the rest of its picture, and what keeps its blur.

use super::deconvolver::{Lights, Variant};
use super::lens_operator::{Accuracy, LensOperator};
use super::light_sources::{LightSearch, LightSources};
use super::noise_estimate::estimate_noise;
use super::noise_model::NoiseModel;
use super::{Canvas, Deconvolver, Highlights, ramp};
use crate::{Plane, Scene};
use seidel_optics::Progress;
use seidel_optics::error::Result;

/// Light from clipped samples and highlights, in units of the highlight threshold, at which a pixel begins to keep its
/// blur and keeps all of it.
const KEPT_HIGHLIGHT_LIGHT: [f32; 2] = [0.003, 0.02];
/// Normalisation errors at depth edges at which a pixel begins to keep its blur and keeps all of it.
const KEPT_NORMALISATION_ERROR: [f32; 2] = [0.05, 0.15];

/// The inputs that all planes of a plate have in common.
pub(super) struct PlateInputs<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) canvas: Canvas,
    pub(super) highlights: &'a Highlights,
    pub(super) variant: Variant,
}

/// A plane whose lights are separated from its picture.
pub(super) struct Separated {
    pub(super) canvas: Canvas,
    pub(super) operator: LensOperator,
    /// Standard deviation of the noise.
    pub(super) noise: f64,
    /// Standard deviation of a typical sample: noise and model error.
    pub(super) deviation: f64,
    pub(super) clip_level: Option<f32>,
    pub(super) lights: LightSources,
    /// The samples without the lights.
    pub(super) rest: Vec<f32>,
    /// The share of its blur that each pixel keeps.
    pub(super) kept: Vec<f32>,
}

impl PlateInputs<'_> {
    /// Separates the lights of `plane` from its picture.
    ///
    /// # Errors
    /// A lens that cannot be drawn; cancellation by `progress`.
    pub(super) fn separate(
        &self,
        deconvolver: &Deconvolver,
        plane: &Plane,
        progress: &Progress,
    ) -> Result<Separated> {
        let canvas = self.canvas;
        let operator = LensOperator::new(self.scene, &canvas, plane.weights)?;
        let noise = (deconvolver.noise)
            .unwrap_or_else(|| estimate_noise(plane.samples, &canvas, &operator));
        let clip_level = deconvolver.saturation.level(plane.samples, noise);
        let model_error = self.variant.model_error;
        let mirrored = canvas.extend_by_mirroring(plane.samples);
        let deviation = NoiseModel::new(&mirrored, noise, model_error).deviation();
        let lights = match self.variant.lights {
            Lights::KeepBlur => LightSources::none(plane.samples.len()),
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
        let kept = self.kept_shares(plane.samples, clip_level, &lights, &operator)?;
        Ok(Separated {
            canvas,
            operator,
            noise,
            deviation,
            clip_level,
            rest: lights.taken_off(plane.samples),
            lights,
            kept,
        })
    }

    /// Returns the share of its blur that each pixel of the plate keeps, 0 to 1. Explained lights keep none.
    ///
    /// Clipped samples are lower bounds of the light, so sharpening the pixels that get their light makes these ring.
    /// Highlights and lights that the lens does not explain are treated like them. At depth edges part of the light is hidden.
    fn kept_shares(
        &self,
        samples: &[f32],
        clip_level: Option<f32>,
        lights: &LightSources,
        operator: &LensOperator,
    ) -> Result<Vec<f32>> {
        let count = self.canvas.plate_pixel_count();
        let mut kept = vec![0.0; count];
        if let Some(errors) = operator.normalisation_error() {
            let errors = self.canvas.crop(&errors).into_iter();
            kept = errors
                .map(|error| ramp(error, KEPT_NORMALISATION_ERROR))
                .collect();
        }
        // In units of the highlight threshold; clipped samples count as one at least.
        let excess = |k: usize| {
            if lights.explained[k] {
                return 0.0;
            }
            let clipped = clip_level.is_some_and(|level| samples[k] >= level);
            let least = if clipped || lights.unexplained[k] {
                1.0
            } else {
                0.0
            };
            self.highlights.excess(k).max(least)
        };
        if (0..count).any(|k| excess(k) > 0.0) {
            let blurred = operator.apply(&self.canvas.embed(0.0, excess), Accuracy::Draft)?;
            for (k, light) in self.canvas.crop(&blurred).iter().enumerate() {
                let kept_by_light = if excess(k) > 0.0 {
                    1.0
                } else {
                    ramp(*light, KEPT_HIGHLIGHT_LIGHT)
                };
                kept[k] = kept_by_light.max(kept[k]);
            }
        }
        Ok(kept)
    }
}
