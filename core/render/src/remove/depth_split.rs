//! The split of a plate into foreground and background, where a clean plate shows what the foreground hides.
//!
//! With occlusion the plate is
//!
//! ```text
//! b = F M x + (1 - F M) B y
//! ```
//!
//! F and B are the lens at the vergences of foreground and background, x and y their sharp images, and M is the matte: 1
//! where the plate shows foreground. The depths of plate and clean plate give M, so the transmission T = 1 - F M is known,
//! and the clean plate is B y. Each image is completed to a plate without depth edges, whose blur is removed by itself:
//!
//! - the background: the plate where T is 1, the clean plate elsewhere;
//! - the foreground: b - T B y, to which the blurred light of an extension beyond the matte is added.

use super::canvas::Canvas;
use super::hole_filling::fill_holes;
use super::lens_operator::LensOperator;
use super::noise_estimate::estimate_noise;
use super::normal_deviate::normal_deviate;
use super::{Clipping, Deconvolver, Saturation, SharpPlane, darkest_sample, ramp};
use crate::{DepthLayers, LayerSpacing, Plane, Scene, VergencePass};
use rayon::prelude::*;
use seidel_optics::error::{Error, Result};

/// Least distance of a foreground from its background, depth layers.
const LEAST_DISTANCE: f32 = 1.0;
/// Transmissions at which the background is that of the clean plate, and that of the plate.
const PLATE_TRANSMISSION: [f32; 2] = [0.98, 1.0];
/// Transmission below which the colour of the foreground is known, and clipped samples are its own.
const FOREGROUND_TRANSMISSION: f32 = 0.5;

/// A plate split at the edges of its foreground.
pub struct DepthSplit<'a> {
    scene: &'a Scene<'a>,
    background: VergencePass<'a>,
    /// Whether each pixel of the plate shows foreground.
    matte: Vec<bool>,
    /// Vergence of the foreground, continued beyond the matte.
    foreground: Vec<f32>,
}

/// A plane of a plate split into foreground and background: samples, and the settings of their removal.
#[derive(Debug, Clone)]
pub struct SplitPlane {
    /// Samples of the foreground, and the removal of its blur.
    pub foreground: (Deconvolver, Vec<f32>),
    /// Samples of the background, and the removal of its blur.
    pub background: (Deconvolver, Vec<f32>),
    /// Share of the background's light that passes the foreground.
    transmission: Vec<f32>,
    clipping: Option<Clipping>,
}

impl<'a> DepthSplit<'a> {
    /// Splits the plate of `scene` by the vergence of its clean plate, `background`. `None` if the plate lies at one vergence,
    /// or is nowhere nearer than its background by a layer of depth.
    ///
    /// # Errors
    /// A background with another number of pixels.
    pub fn new(scene: &'a Scene<'a>, background: VergencePass<'a>) -> Result<Option<Self>> {
        let VergencePass::PerPixel(pass) = scene.vergence else {
            return Ok(None);
        };
        if let VergencePass::PerPixel(own) = background
            && own.len() != pass.len()
        {
            return Err(Error::new(
                "background depth",
                format!("has {} pixels, the plate {}", own.len(), pass.len()),
                "give one of the plate's size",
            ));
        }
        let behind = |k: usize| match background {
            VergencePass::Constant(vergence) => vergence,
            VergencePass::PerPixel(own) => f64::from(own[k]),
        };
        let ends = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
        let vergences = (0..pass.len()).flat_map(|k| [f64::from(pass[k]), behind(k)]);
        let (lowest, highest) = vergences.fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        let layers = DepthLayers::new(scene, lowest, highest, LayerSpacing::BY_BLUR);
        let nearness: Vec<f32> = (pass.par_iter())
            .map(|vergence| layers.coordinate(f64::from(*vergence)))
            .collect();
        let is_foreground = |k: usize| nearness[k] - layers.coordinate(behind(k)) >= LEAST_DISTANCE;
        let matte: Vec<bool> = (0..pass.len()).into_par_iter().map(is_foreground).collect();
        if !matte.contains(&true) {
            return Ok(None);
        }
        // Pixels on the outline may hold a depth between foreground and background.
        let is_inside = |k: usize| {
            matte[k]
                && neighbours(k, scene.width, scene.height)
                    .all(|near| nearness[near] < nearness[k] + LEAST_DISTANCE)
        };
        let inside: Vec<bool> = (0..pass.len()).into_par_iter().map(is_inside).collect();
        Ok(Some(Self {
            scene,
            background,
            foreground: fill_holes(pass, scene.width, &inside),
            matte,
        }))
    }

    /// Returns the scene of the foreground.
    pub fn foreground_scene(&self) -> Scene<'_> {
        Scene {
            vergence: VergencePass::PerPixel(&self.foreground),
            ..*self.scene
        }
    }

    /// Returns the scene of the background.
    pub fn background_scene(&self) -> Scene<'_> {
        Scene {
            vergence: self.background,
            ..*self.scene
        }
    }

    /// Splits a `plane` of the plate by the same plane of the clean plate, whose blur `deconvolver` is to remove.
    ///
    /// # Errors
    /// A lens that cannot be drawn, and planes that are not of the plate's size.
    pub fn split(
        &self,
        deconvolver: &Deconvolver,
        plane: &Plane,
        clean: &[f32],
    ) -> Result<SplitPlane> {
        let scene = self.scene;
        scene.check(&[*plane])?;
        scene.check_samples("background", clean)?;
        let (samples, weights) = (plane.samples, plane.weights);
        let noise = match deconvolver.noise {
            Some(noise) => noise,
            None => estimate_noise(scene, plane)?.deviation,
        };
        let in_front = self.foreground_scene();
        let canvas = Canvas::new(&in_front);
        let lens = ForegroundLens {
            operator: LensOperator::new(&in_front, &canvas, weights)?,
            canvas,
        };
        let covered = lens.blur(&self.matte_samples())?;
        let transmission: Vec<f32> = covered.iter().map(|c| (1.0 - c).clamp(0.0, 1.0)).collect();
        let background: Vec<f32> = (0..samples.len())
            .map(|k| clean[k] + ramp(transmission[k], PLATE_TRANSMISSION) * (samples[k] - clean[k]))
            .collect();
        let own: Vec<f32> = (0..samples.len())
            .map(|k| samples[k] - transmission[k] * background[k])
            .collect();
        let is_known = |k: usize| self.matte[k] && transmission[k] < FOREGROUND_TRANSMISSION;
        let known: Vec<bool> = (0..samples.len()).map(is_known).collect();
        let colours: Vec<f32> = (own.iter().zip(&transmission))
            .map(|(own, t)| own / (1.0 - t).max(1.0 - FOREGROUND_TRANSMISSION))
            .collect();
        let extension = fill_holes(&colours, scene.width, &known);
        let beyond: Vec<f32> = (extension.iter().zip(&self.matte))
            .map(|(sample, matte)| if *matte { 0.0 } else { *sample })
            .collect();
        let added = lens.blur(&beyond)?;
        let level = deconvolver.saturation.level(samples, noise);
        // Without noise of its own the extension would pass for a plate with less noise, and be fitted too closely.
        let noise_beyond = |k: usize| {
            let share = f64::from(ramp(transmission[k], PLATE_TRANSMISSION));
            (noise * share * normal_deviate((samples.len() + k) as u64)) as f32
        };
        // An error of T B y must not make light negative that is not negative in the plate.
        let darkest = darkest_sample(samples);
        let mut foreground: Vec<f32> = (0..samples.len())
            .map(|k| (own[k] + added[k] + noise_beyond(k)).max(darkest))
            .collect();
        if let Some(level) = level {
            for (k, sample) in foreground.iter_mut().enumerate() {
                if samples[k] >= level && transmission[k] < FOREGROUND_TRANSMISSION {
                    *sample = sample.max(level);
                }
            }
        }
        let of_foreground = Deconvolver {
            noise: Some(noise),
            saturation: level.map_or(Saturation::Never, |level| Saturation::Level(level.into())),
            ..*deconvolver
        };
        Ok(SplitPlane {
            foreground: (of_foreground, foreground),
            background: (*deconvolver, background),
            transmission,
            clipping: level.map(|level| Clipping {
                level: level.into(),
                count: samples.iter().filter(|v| **v >= level).count(),
            }),
        })
    }

    /// Joins the sharp foreground and background of a `plane` of the plate. The residual is that of both where they show.
    pub fn join(
        &self,
        plane: &SplitPlane,
        foreground: &SharpPlane,
        background: &SharpPlane,
    ) -> SharpPlane {
        let [front, back] = [foreground.canvas, background.canvas];
        let canvas = Canvas {
            margin_x: front.margin_x.max(back.margin_x),
            margin_y: front.margin_y.max(back.margin_y),
            ..front
        };
        let fitted = |sharp: &SharpPlane| canvas.fit(&sharp.canvas, &sharp.sharp);
        let (in_front, behind) = (fitted(foreground), fitted(background));
        let matte = canvas.extend_by_replication(&self.matte_samples());
        let sharp = (in_front.iter().zip(&behind).zip(&matte))
            .map(|((front, back), matte)| if *matte > 0.5 { *front } else { *back });
        let residual = (plane.transmission.iter().enumerate()).map(|(k, t)| {
            let in_front = 1.0 - ramp(*t, PLATE_TRANSMISSION);
            in_front * foreground.residual[k] + t * background.residual[k]
        });
        SharpPlane {
            canvas,
            sharp: sharp.collect(),
            residual: residual.collect(),
            noise: foreground.noise,
            clipping: plane.clipping,
            misfit: foreground.misfit.max(background.misfit),
            confidence: self.join_maps(&foreground.confidence, &background.confidence),
            kept: foreground.kept.join(&background.kept, &self.matte),
        }
    }

    /// Joins maps of foreground and background, of the plate's size.
    pub fn join_maps(&self, foreground: &[f32], background: &[f32]) -> Vec<f32> {
        let pairs = foreground.iter().zip(background).zip(&self.matte);
        let chosen = pairs.map(|((front, back), matte)| if *matte { *front } else { *back });
        chosen.collect()
    }

    /// Returns the matte as samples: 1 in the foreground, 0 beyond.
    fn matte_samples(&self) -> Vec<f32> {
        let matte = self.matte.iter();
        matte.map(|m| f32::from(u8::from(*m))).collect()
    }
}

/// The lens at the vergence of the foreground, on the plate.
struct ForegroundLens {
    canvas: Canvas,
    operator: LensOperator,
}

impl ForegroundLens {
    /// Blurs a plane of the plate, mirrored at its edges.
    fn blur(&self, samples: &[f32]) -> Result<Vec<f32>> {
        let image = (self.operator).image(self.canvas.extend_by_mirroring(samples));
        Ok(self.canvas.crop(&self.operator.apply(&image)?))
    }
}

/// Returns the pixels beside and diagonal to the pixel at row-major `index`.
fn neighbours(index: usize, width: usize, height: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (index % width, index / width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    let all = rows.flat_map(move |row| {
        (x.saturating_sub(1)..(x + 2).min(width)).map(move |column| row * width + column)
    });
    all.filter(move |near| *near != index)
}
