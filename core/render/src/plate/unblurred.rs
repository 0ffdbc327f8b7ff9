//! A plate's light without the blur of its lens, plane by plane.

use super::{Light, Rendering};
use crate::remove::{Canvas, LensCheck, Lights, Removal, Removed, Saturation};
use crate::{Gather, Occlusion, Scene, VergencePass};
use rayon::prelude::*;
use seidel_optics::error::Result;
use seidel_optics::predict::Predictor;

/// What a plate is known to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Unblur {
    /// Standard deviation of the noise of each colour, or one for all; told from the plate where there is none.
    pub noise: Vec<f64>,
    /// Which samples of colours are clipped.
    pub saturation: Saturation,
}

/// The planes of a plate without its blur, colours first.
#[derive(Debug, Clone)]
pub struct Unblurred {
    removed: Vec<Removed>,
    colours: usize,
    /// How many times as strong noise is in each colour, at each pixel of the plate; empty unless asked for.
    pub noise_gain: Vec<Vec<f32>>,
}

impl Unblur {
    /// `light` without the blur of `scene`, its planes seen with `weights`, and what becomes of noise if `gain` is asked
    /// for; `progress` is told the share done, and says whether to go on.
    ///
    /// # Errors
    /// Those of [`Removal::remove`].
    pub fn removed(
        &self,
        scene: &Scene,
        (light, weights): (&Light, &[Vec<f64>]),
        gain: bool,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Unblurred> {
        let planes = light.with_weights(weights);
        let colours = light.colour_count();
        let (mut removed, mut noise_gain) = (Vec::with_capacity(planes.len()), Vec::new());
        let steps = planes.len() + if gain { colours } else { 0 };
        let mut done = 0;
        let lights = Lights::of(&planes[..colours], scene.width);
        for (index, plane) in planes.iter().enumerate() {
            let removal = self.of_plane(index, colours);
            let share = |done: usize, part: f64| progress((done as f64 + part) / steps as f64);
            let found = match index < colours {
                true => removal.remove_about(&lights, scene, &[*plane], &|part| share(done, part)),
                false => removal.remove(scene, &[*plane], &|part| share(done, part)),
            }?;
            done += 1;
            if gain && index < colours {
                let tell = |part| share(done, part);
                noise_gain.extend(removal.noise_gain(&lights, scene, &[*plane], &found, &tell)?);
                done += 1;
            }
            removed.extend(found);
        }
        Ok(Unblurred {
            removed,
            colours,
            noise_gain,
        })
    }

    /// How the blur of `scene` compares with what the colours of `light` show, its planes seen with `weights`.
    ///
    /// # Errors
    /// Those of [`LensCheck::of`].
    pub fn lens_check(
        &self,
        scene: &Scene,
        (light, weights): (&Light, &[Vec<f64>]),
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<LensCheck> {
        let colours = light.colour_count();
        let planes = light.with_weights(weights).into_iter().enumerate();
        let planes: Vec<_> = (planes.take(colours))
            .map(|(index, plane)| (self.of_plane(index, colours), plane))
            .collect();
        LensCheck::of(scene, &planes, progress)
    }

    /// Coverage is never clipped light, and its noise is its own.
    fn of_plane(&self, index: usize, colours: usize) -> Removal {
        let default = Removal::default();
        if index >= colours {
            return Removal {
                saturation: Saturation::Never,
                ..default
            };
        }
        Removal {
            noise: self.noise.get(index).or(self.noise.first()).copied(),
            saturation: self.saturation,
            ..default
        }
    }
}

impl Unblurred {
    /// What was found of each colour.
    pub fn colours(&self) -> &[Removed] {
        &self.removed[..self.colours]
    }

    /// Where the plate lies on the planes: the same for all, as it follows from the lens.
    pub fn canvas(&self) -> Option<Canvas> {
        self.removed.first().map(|removed| removed.canvas)
    }

    /// Standard deviation of the noise of each plane.
    pub fn noise(&self) -> Vec<f64> {
        self.removed.iter().map(|removed| removed.noise).collect()
    }

    /// How much of each pixel of the plate was seen and not guessed, for each colour.
    pub fn confidence(&self) -> Vec<Vec<f32>> {
        let colours = self.colours().iter();
        colours.map(|removed| removed.confidence.clone()).collect()
    }

    /// The planes on their canvas, coverage within 0..1.
    pub fn sharp(&self) -> Vec<Vec<f32>> {
        let mut planes: Vec<Vec<f32>> = (self.removed.iter())
            .map(|removed| removed.sharp.clone())
            .collect();
        self.hold_coverage(&mut planes);
        planes
    }

    /// Brings the planes of coverage back into 0..1.
    pub fn hold_coverage(&self, planes: &mut [Vec<f32>]) {
        let coverage = planes.iter_mut().skip(self.colours);
        for sample in coverage.flatten() {
            *sample = sample.clamp(0.0, 1.0);
        }
    }

    /// Adds the plate's own grain to the colours of `planes`, which lie on the canvas, or are `cropped` to the plate.
    pub fn add_grain(&self, planes: &mut [Vec<f32>], cropped: bool) {
        for (plane, removed) in planes.iter_mut().zip(self.colours()) {
            let grain = match cropped {
                true => removed.canvas.cropped(&removed.grain()),
                false => removed.grain(),
            };
            plane
                .par_iter_mut()
                .zip(&grain)
                .for_each(|(sample, grain)| *sample += grain);
        }
    }

    /// The plate as `scene`, the plate through another `lens`, draws what was found, with the plate's own grain, as the
    /// lens's sensor records it; `light` is that of the plate, its planes seen with `weights`. Nothing where there is
    /// no plane.
    ///
    /// # Errors
    /// Those of the renderer.
    pub fn seen_by(
        &self,
        (scene, lens): (&Scene, &Predictor),
        (light, weights): (&Light, &[Vec<f64>]),
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        let Some(canvas) = self.canvas() else {
            return Ok(Vec::new());
        };
        let light = light.with_planes(self.sharp());
        let pass = match scene.vergence {
            VergencePass::PerPixel(pass) => Some(canvas.extended(pass)),
            VergencePass::Constant(_) => None,
        };
        let rendering = Rendering {
            scene: &canvas.scene(scene, pass.as_deref()),
            planes: &light.with_weights(weights),
            occlusion: Some(Occlusion::default()),
            extended: false,
        };
        let blurred = rendering.by(&Gather::default(), progress)?.planes;
        let mut planes: Vec<_> = blurred.iter().map(|plane| canvas.cropped(plane)).collect();
        self.hold_coverage(&mut planes);
        self.add_grain(&mut planes, true);
        light.develop(lens, weights, &mut planes);
        Ok(planes)
    }
}
