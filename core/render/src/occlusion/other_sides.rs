//! Pixels that show two sides of an edge, whose light is known to be divided.

use super::depth_layers::DepthLayers;
use super::extra_samples::ExtraSamples;
use super::layered_plate::LayeredPlate;
use crate::Scene;
use rayon::prelude::*;
use seidel_optics::error::Result;

/// The other side of each pixel that shows two: the plate holds the light of the side that covers more of it, as if it covered all.
#[derive(Debug, Clone, Copy)]
pub struct OtherSides<'a> {
    /// Light of the other side in each plane, row-major, multiplied by its share of the pixel.
    pub planes: &'a [&'a [f32]],
    /// Share of each pixel that the other side covers, 0 to 1/2.
    pub share: &'a [f32],
    /// Vergence of the other side, 1/m.
    pub vergence: &'a [f32],
}

impl OtherSides<'_> {
    pub(super) fn check(&self, scene: &Scene) -> Result<()> {
        for (name, samples) in [("share", self.share), ("vergence", self.vergence)] {
            scene.check_samples(&format!("{name} of other sides"), samples)?;
        }
        let mut planes = self.planes.iter();
        planes.try_for_each(|plane| scene.check_samples("light of other sides", plane))
    }

    /// Returns the samples that the other sides of `input` add, and what they take from its own, row by row.
    pub(super) fn samples(&self, input: &LayeredPlate, layers: &DepthLayers) -> Vec<ExtraSamples> {
        let row = |row: usize| {
            let mut out = ExtraSamples::default();
            for column in 0..input.width {
                let index = row * input.width + column;
                let share = self.share[index];
                if share == 0.0 {
                    continue;
                }
                let own = input.coordinates[index];
                let other = layers.coordinate(f64::from(self.vergence[index]));
                // A far side is whole behind a near one.
                let taken = if own > other { share } else { 0.0 };
                if taken > 0.0 {
                    out.columns.push(column as u32);
                    out.weights.push(-taken);
                    out.coordinates.push(own);
                    let light = input
                        .planes
                        .iter()
                        .map(|plane| -taken * plane.samples[index]);
                    out.samples.extend(light);
                }
                out.columns.push(column as u32);
                out.weights.push(share);
                out.coordinates.push(other);
                out.samples
                    .extend(self.planes.iter().map(|plane| plane[index]));
            }
            out
        };
        let height = input.height;
        (0..height).into_par_iter().map(row).collect()
    }
}
