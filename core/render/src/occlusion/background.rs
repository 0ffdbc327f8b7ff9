//! A given background: what a plate shows where its foreground is taken away.

use super::depth_layers::DepthLayers;
use super::extra_samples::ExtraSamples;
use super::farthest_nearby::FarthestNearby;
use super::layered_plate::LayeredPlate;
use crate::{Scene, VergencePass};
use rayon::prelude::*;
use seidel_optics::error::{Error, Result};

/// Distance behind the plate's own surface from which a background sample is a surface of its own, layers.
const LEAST_DISTANCE: f32 = 1.0;

/// A background: what a plate shows where its foreground is taken away, such as a clean plate with its depth.
#[derive(Debug, Clone, Copy)]
pub struct Background<'a> {
    /// Samples of each plane of the render, one a pixel, row-major; premultiplied as the plate.
    pub planes: &'a [&'a [f32]],
    /// Vergence of its pixels.
    pub vergence: VergencePass<'a>,
}

impl Background<'_> {
    /// Checks that the background fits a render of `planes` planes of `scene`.
    ///
    /// # Errors
    /// Another number of planes, planes of another size, and samples that are not finite, by pixel.
    pub(super) fn check(&self, scene: &Scene, planes: usize) -> Result<()> {
        if self.planes.len() != planes {
            return Err(Error::new(
                "background",
                format!("has {} planes, the plate {planes}", self.planes.len()),
                "give one for each plane of the plate",
            ));
        }
        for (index, plane) in self.planes.iter().enumerate() {
            scene.check_samples(&format!("background plane {index}"), plane)?;
        }
        match self.vergence {
            VergencePass::PerPixel(pass) => scene.check_samples("background depth", pass),
            VergencePass::Constant(_) => Ok(()),
        }
    }

    /// Returns the vergence of the pixel at row-major `index`, 1/m.
    pub(super) fn vergence_at(&self, index: usize) -> f64 {
        match self.vergence {
            VergencePass::Constant(vergence) => vergence,
            VergencePass::PerPixel(pass) => f64::from(pass[index]),
        }
    }

    /// Returns the smallest and the largest vergence, 1/m.
    pub(super) fn vergence_range(&self) -> (f64, f64) {
        match self.vergence {
            VergencePass::Constant(vergence) => (vergence, vergence),
            VergencePass::PerPixel(pass) => {
                let ends = |(low, high): (f64, f64), v: &f32| {
                    (low.min(f64::from(*v)), high.max(f64::from(*v)))
                };
                pass.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends)
            }
        }
    }

    /// Returns the background samples that lie behind a surface of the plate, where the blur of its edges may uncover them.
    pub(super) fn hidden_samples(
        &self,
        input: &LayeredPlate,
        layers: &DepthLayers,
    ) -> Vec<ExtraSamples> {
        let farthest = FarthestNearby::new(input, layers);
        let row = |row: usize| {
            let mut out = ExtraSamples::default();
            for column in 0..input.width {
                let index = row * input.width + column;
                let surface = input.coordinates[index] - LEAST_DISTANCE;
                if farthest.at(column, row) > surface {
                    continue;
                }
                let coordinate = layers.coordinate(self.vergence_at(index));
                if coordinate <= surface {
                    out.columns.push(column as u32);
                    out.weights.push(1.0);
                    out.coordinates.push(coordinate);
                    let samples = self.planes.iter().map(|plane| plane[index]);
                    out.samples.extend(samples);
                }
            }
            out
        };
        (0..input.height).into_par_iter().map(row).collect()
    }
}
