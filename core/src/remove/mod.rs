//! Taking a lens's blur off plates: the picture that the lens, by the fast renderer's operator, makes the plate of.
//!
//! What the lens passes less of than there is noise cannot be had back; there the picture stays as smooth as
//! sharp pictures mostly are (`prior`). The noise is told from the plate (`noise`), and how much weight the prior
//! has follows from the noise and from the picture's own slopes (`solve`), never from what is not known.

mod local;
mod noise;
mod prior;
mod solve;
#[cfg(test)]
mod tests;

use crate::error::{Error, Result};
use crate::render::{Operator, Plane, Quality, Scene, VergencePass};
use local::Local;
use solve::{Task, solve};

/// How blur is removed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Removal {
    /// Standard deviation of the planes' noise, in their own units; told from each plane if none is given.
    pub noise: Option<f64>,
    /// How exact the operator is.
    pub quality: Quality,
    /// How often the picture is put right.
    pub rounds: usize,
}

impl Default for Removal {
    /// What gains most within ten times the time of one blur.
    fn default() -> Self {
        Self {
            noise: None,
            quality: Quality::Draft,
            rounds: 8,
        }
    }
}

/// A plane without its blur.
#[derive(Debug, Clone, PartialEq)]
pub struct Removed {
    /// Light, row-major.
    pub plane: Vec<f32>,
    /// Standard deviation of the blurred plane's noise, as given or as told from it.
    pub noise: f64,
}

impl Removal {
    /// `planes` without the blur of `scene`, which is at one vergence. The same to the bit for any number of
    /// threads.
    ///
    /// # Errors
    /// A scene, planes or a noise that cannot be, a lens that cannot be drawn, a vergence that varies, and
    /// `progress`, told the share done, saying to stop.
    pub fn remove(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Removed>> {
        scene.check(planes)?;
        if let Some(noise) = self.noise
            && !(noise.is_finite() && noise >= 0.0)
        {
            return Err(Error::new(
                "noise",
                format!("is {noise}"),
                "give a standard deviation of zero or more",
            ));
        }
        let VergencePass::Constant(vergence) = scene.vergence else {
            return Err(Error::new(
                "vergence",
                "varies over the plate",
                "remove the blur of one distance at a time",
            ));
        };
        let one = |(index, plane): (usize, &Plane)| {
            let share = |part: f64| progress((index as f64 + part) / planes.len() as f64);
            let noise = self
                .noise
                .unwrap_or_else(|| noise::deviation(plane.samples, scene.width));
            let task = Task {
                blurred: plane.samples,
                width: scene.width,
                noise,
                rounds: self.rounds,
                operator: &Operator::new(scene, &[plane.weights.to_vec()], self.quality)?,
                local: &Local::new(scene, plane.weights, vergence)?,
            };
            Ok(Removed {
                plane: solve(&task, &share)?,
                noise,
            })
        };
        planes.iter().enumerate().map(one).collect()
    }
}
