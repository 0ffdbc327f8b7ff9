//! Taking a lens's blur off plates: the picture that the lens, by the fast renderer's operator, makes the plate of.
//!
//! What the lens passes less of than there is noise cannot be had back; there the picture stays as smooth as
//! sharp pictures mostly are (`prior`). The noise is told from the plate (`noise`), and how much weight the prior
//! has follows from the noise and from the picture's own slopes (`solve`), never from what is not known. The picture
//! goes on beyond the plate's edges (`canvas`), and clipped samples, which say only that there was more
//! light (`saturation`), keep their blur with what they land on.

mod canvas;
mod detail;
mod filled;
mod kept;
mod lens_check;
mod lights;
mod local;
mod noise;
mod noise_gain;
#[cfg(test)]
mod parts_tests;
mod prior;
mod saturation;
mod solve;
mod squares;
mod sums;
#[cfg(test)]
mod test_scenes;
#[cfg(test)]
mod tests;
mod transform;
mod trust;
mod view;

pub use canvas::Canvas;
pub use kept::changed;
pub use lens_check::LensCheck;
pub use lights::Lights;
pub use saturation::Saturation;

use crate::{Plane, Scene};
use filled::filled;
use rayon::prelude::*;
use seidel_optics::error::{Error, Result};
use solve::{Task, solve};
use view::{Care, View};

/// How exactly operators and lenses are known, as a share of the light: what is less counts as noise.
const INEXACT: f64 = 2e-3;

/// Shares of light from clipped samples, or of what a light at least is, at which a pixel begins to keep its blur, and keeps
/// all of it.
const LANDED: [f32; 2] = [0.003, 0.02];

/// Shares by which even light would not stay even (depth edges) from which on the same is done.
const UNEVEN: [f32; 2] = [0.05, 0.15];

/// How blur is removed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Removal {
    /// Standard deviation of the planes' noise, in their own units; told from each plane if none is given.
    pub noise: Option<f64>,
    /// Which samples are clipped.
    pub saturation: Saturation,
    /// How often the picture is put right.
    pub rounds: usize,
}

impl Default for Removal {
    /// About ten times the time of one blur (docs/background/remove.md).
    fn default() -> Self {
        Self {
            noise: None,
            saturation: Saturation::Told,
            rounds: 7,
        }
    }
}

/// A plane without its blur, and what was found on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Removed {
    /// Where the plate lies on the canvas.
    pub canvas: Canvas,
    /// Light of the whole canvas without the blur, row-major; clipped lights, those many times as
    /// bright as most, and what they land on keep theirs. Beyond the plate it is what lands on the plate from there.
    pub sharp: Vec<f32>,
    /// The plane less what the lens makes of `sharp`, row-major: noise, and what the lens does not explain. Zero at
    /// clipped samples and what they land on.
    pub rest: Vec<f32>,
    /// Standard deviation of the plane's noise, as given or as told from it.
    pub noise: f64,
    /// The level from which on samples are clipped, and how many are.
    pub clipped: Option<(f64, usize)>,
    /// Root of the mean square of `rest`, in standard deviations of what the noise and inexact lenses let expect: well above
    /// one, the lens does not explain the plate. Lights brighter than most count less.
    pub misfit: f64,
    /// How much of the detail at each pixel of the plate, of all waves up to the pixels' own, is told by the plate, from 0 to
    /// 1; the rest is as smooth as sharp pictures mostly are. 0 where the blur is kept.
    pub confidence: Vec<f32>,
}

impl Removed {
    /// The noise of the plate, on the canvas: `rest`, held within three standard deviations of the noise, mirrored
    /// beyond the plate. Added to `sharp` it gives the picture the plate's own grain.
    pub fn grain(&self) -> Vec<f32> {
        let most = (3.0 * self.noise) as f32;
        let held: Vec<f32> = self.rest.par_iter().map(|v| v.clamp(-most, most)).collect();
        self.canvas.mirrored(&held)
    }
}

impl Removal {
    /// `planes` without the blur of `scene`; a vergence that varies over the plate is that of the sharp picture.
    /// Scenes' edges are not asked: the light about the plate is sought as well. The [`Lights`] of any of the planes keep
    /// their blur. The same to the bit for any number of threads.
    ///
    /// # Errors
    /// A scene, planes or a noise that cannot be, a lens that cannot be drawn, and `progress`, told the share done,
    /// saying to stop.
    pub fn remove(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Removed>> {
        self.remove_about(&Lights::of(planes, scene.width), scene, planes, progress)
    }

    /// The same, these `lights` keeping their blur: for planes of one plate that are given one by one.
    ///
    /// # Errors
    /// Those of [`Removal::remove`].
    pub fn remove_about(
        &self,
        lights: &Lights,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Removed>> {
        self.remove_by(lights, scene, planes, (INEXACT, true), progress)
    }

    /// The same; what is less than a share of the light counts as noise, and detail is told from it in the end or not.
    fn remove_by(
        &self,
        lights: &Lights,
        scene: &Scene,
        planes: &[Plane],
        by: (f64, bool),
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Removed>> {
        scene.check(planes)?;
        self.check()?;
        let canvas = Canvas::of(scene);
        let one = |(index, plane): (usize, &Plane)| {
            let share = |part: f64| progress((index as f64 + part) / planes.len() as f64);
            self.remove_one((scene, canvas, lights), plane, by, &share)
        };
        planes.iter().enumerate().map(one).collect()
    }

    fn check(&self) -> Result<()> {
        if let Some(noise) = self.noise
            && !(noise.is_finite() && noise >= 0.0)
        {
            return Err(Error::new(
                "noise",
                format!("is {noise}"),
                "give a standard deviation of zero or more",
            ));
        }
        if let Saturation::From(level) = self.saturation
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

    fn remove_one(
        &self,
        (scene, canvas, lights): (&Scene, Canvas, &Lights),
        plane: &Plane,
        (inexact, detailed): (f64, bool),
        progress: &dyn Fn(f64) -> bool,
    ) -> Result<Removed> {
        let even = plane.samples.windows(2).all(|pair| pair[0] == pair[1]);
        if even {
            // Light of one level has no blur: opaque alpha stays opaque.
            return Ok(Removed {
                canvas,
                sharp: canvas.extended(plane.samples),
                rest: vec![0.0; plane.samples.len()],
                noise: self.noise.unwrap_or(0.0),
                clipped: None,
                misfit: 0.0,
                confidence: vec![1.0; plane.samples.len()],
            });
        }
        let view = View::new(scene, &canvas, plane.weights)?;
        let noise = self
            .noise
            .unwrap_or_else(|| noise::deviation(plane.samples, &canvas, &view));
        let level = self.saturation.level(plane.samples, noise);
        let is_clipped = |sample: f32| level.is_some_and(|level| sample >= level);
        let light = |k: usize| {
            lights
                .at(k)
                .max(f32::from(u8::from(is_clipped(plane.samples[k]))))
        };
        let kept = self.kept_as_it_is(&canvas, &view, light)?;
        let known = canvas.with_plate(false, |k| kept[k] == 0.0);
        let on_plate: Vec<bool> = kept.iter().map(|kept| *kept == 0.0).collect();
        let held = filled(plane.samples, scene.width, &on_plate);
        let task = Task {
            blurred: &canvas.mirrored(&held),
            canvas,
            known: &known,
            noise,
            inexact,
            rounds: self.rounds,
            detailed,
            view: &view,
        };
        let (mut found, bowl) = solve(&task, progress)?;
        let (rest, misfit) = task.rest(&found);
        let own = canvas.with_plate(0, |k| if kept[k] > 0.0 { k + 1 } else { 0 });
        for (sample, own) in found.plane.iter_mut().zip(own) {
            if own > 0 {
                *sample += kept[own - 1] * (plane.samples[own - 1] - *sample);
            }
        }
        let told = canvas.cropped(&view.mean_over_waves(|h, slope| bowl.told(h, slope))?);
        let confidence = told.iter().zip(&kept);
        let confidence = confidence.map(|(told, kept)| told.clamp(0.0, 1.0) * (1.0 - kept));
        let clipped = level.map(|level| {
            let count = plane.samples.iter().filter(|v| is_clipped(**v)).count();
            (f64::from(level), count)
        });
        Ok(Removed {
            canvas,
            rest,
            sharp: found.plane,
            noise,
            clipped,
            misfit,
            confidence: confidence.collect(),
        })
    }

    /// How much of each of the plate's pixels keeps its blur, 0 to 1: clipped samples say only that there was more light,
    /// and to sharpen what they land on makes it ring; and what lies about depth edges is hidden in part. `light` is 0 for pixels
    /// that are no lights.
    fn kept_as_it_is(
        &self,
        canvas: &Canvas,
        view: &View,
        light: impl Fn(usize) -> f32,
    ) -> Result<Vec<f32>> {
        let count = canvas.plate.0 * canvas.plate.1;
        let ramp =
            |value: f32, [from, to]: [f32; 2]| ((value - from) / (to - from)).clamp(0.0, 1.0);
        let mut kept = vec![0.0; count];
        if let Some(uneven) = view.uneven() {
            let uneven = canvas.cropped(&uneven);
            kept = uneven.iter().map(|share| ramp(*share, UNEVEN)).collect();
        }
        if (0..count).any(|k| light(k) > 0.0) {
            let landed = view.blurred(&canvas.with_plate(0.0, &light), Care::Quick)?;
            for (k, landed) in canvas.cropped(&landed).iter().enumerate() {
                let of_lights = if light(k) > 0.0 {
                    1.0
                } else {
                    ramp(*landed, LANDED)
                };
                kept[k] = of_lights.max(kept[k]);
            }
        }
        Ok(kept)
    }
}
