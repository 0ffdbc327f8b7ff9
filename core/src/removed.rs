//! A plate without the blur of its lens.

use rayon::prelude::*;
use seidel_optics::error::{Error, Result};
use seidel_render::remove::{
    Canvas, Deconvolver, DepthSplit, Lights, Saturation, SharpPlane, change_map,
    estimate_blur_share,
};
use seidel_render::{Gather, Occlusion, VergencePass};

use crate::finite::ComputedPlane;
use crate::image::Image;
use crate::light_scale::LightScale;
use crate::plane_removal::{NoiseGain, RemovalPlanes};
use crate::planes::PremultipliedPlanes;
use crate::prepared::PreparedPlate;
use crate::prepared_background::PreparedBackground;
use crate::rendering::Rendering;
use crate::session::refocus;
use crate::settings::{Edges, Grain, Quality, RemovalSettings};
use seidel_optics::Progress;

/// A plate without the blur of its lens: the solution of each plane on a canvas somewhat larger than the plate.
#[derive(Debug, Clone)]
pub struct RemovedPlate {
    /// Colours first.
    planes: Vec<SharpPlane>,
    colour_count: usize,
    noise_gain: Vec<Vec<f32>>,
    is_split: bool,
}

impl PreparedPlate {
    /// Removes the blur of the lens.
    ///
    /// The background of the plate is here the clean plate as the lens shows it, blur included. With it, the edges of the
    /// foreground become sharp as well; without it, they keep their blur.
    ///
    /// # Errors
    /// A number of noise values that is neither one nor that of the colours, and those of [`Deconvolver::remove`], cancellation by
    /// `progress` among them.
    pub fn remove(&self, noise_gain: NoiseGain, progress: &Progress) -> Result<RemovedPlate> {
        let RemovalInputs {
            light,
            background,
            settings,
            scale,
        } = self.removal_inputs()?;
        let colour_count = light.colour_count();
        let planes = RemovalPlanes {
            planes: (light.weighted(self.weights()).into_iter().enumerate())
                .map(|(index, plane)| (deconvolver_of_plane(&settings, index, colour_count), plane))
                .collect(),
            colour_count,
        };
        let solved = self.with_optics(|optics| {
            let scene = &optics.scene;
            let whole = || planes.solve(scene, noise_gain, progress);
            let Some(background) = background else {
                return whole();
            };
            let vergence = refocus(optics.focus_remap, background.vergence());
            match DepthSplit::new(scene, vergence.pass())? {
                Some(split) => {
                    let clean = background.light().planes();
                    planes.solve_split(&split, clean, noise_gain, progress)
                }
                None => whole(),
            }
        })?;
        let mut removed = RemovedPlate {
            planes: solved.sharp,
            colour_count,
            noise_gain: solved.noise_gain,
            is_split: solved.is_split,
        };
        if let Some(scale) = scale {
            removed.restore(scale);
        }
        removed.check(&self.names())?;
        Ok(removed)
    }

    /// Returns the light of the plate and its background and the settings of their removal, scaled where arithmetic could overflow.
    ///
    /// # Errors
    /// A number of noise values that is neither one nor that of the colours.
    pub(crate) fn removal_inputs(&self) -> Result<RemovalInputs> {
        let light = self.undeveloped();
        let background = self
            .background()
            .map(|background| background.undeveloped(self.session().predictor(), self.weights()));
        let mut settings = self.session().settings().removal.clone();
        let (given, colours) = (settings.noise.len(), light.colour_count());
        if given > 1 && given != colours {
            return Err(Error::new(
                "noise",
                format!("has {given} values for a plate of {colours} colours"),
                "give one value for all colours, or one for each",
            ));
        }
        let peak = background.as_ref().map_or(0.0, PreparedBackground::peak);
        let Some(scale) = LightScale::for_peak(light.peak().max(peak)) else {
            return Ok(RemovalInputs {
                light,
                background,
                settings,
                scale: None,
            });
        };
        settings.noise.iter_mut().for_each(|v| *v *= scale.factor());
        if let Saturation::Level(level) = &mut settings.saturation {
            *level *= scale.factor();
        }
        Ok(RemovalInputs {
            light: light.reduced_by(scale),
            background: background.map(|background| background.reduced_by(scale)),
            settings,
            scale: Some(scale),
        })
    }

    /// Returns the blur that the plate shows as a share of the lens's blur: 1 where nothing speaks against the lens. Of plates
    /// with a depth pass, parts of even blur are looked at.
    ///
    /// # Errors
    /// Those of [`estimate_blur_share`].
    pub fn blur_share(&self, progress: &Progress) -> Result<f64> {
        let RemovalInputs {
            light, settings, ..
        } = self.removal_inputs()?;
        let settings = &settings;
        self.with_optics(|optics| {
            let colour_count = light.colour_count();
            let planes = light.weighted(self.weights()).into_iter().enumerate();
            let planes: Vec<_> = (planes.take(colour_count))
                .map(|(index, plane)| (deconvolver_of_plane(settings, index, colour_count), plane))
                .collect();
            estimate_blur_share(&optics.scene, &planes, progress)
        })
    }
}

/// The inputs of a removal.
pub(crate) struct RemovalInputs {
    pub(crate) light: PremultipliedPlanes,
    pub(crate) background: Option<PreparedBackground>,
    pub(crate) settings: RemovalSettings,
    /// The scale of the light, if it is not that of the plate.
    pub(crate) scale: Option<LightScale>,
}

/// The settings of one plane: alpha is never clipped, and its noise is estimated from itself.
pub(crate) fn deconvolver_of_plane(
    settings: &RemovalSettings,
    index: usize,
    colour_count: usize,
) -> Deconvolver {
    let default = Deconvolver::default();
    if index >= colour_count {
        return Deconvolver {
            saturation: Saturation::Never,
            lights: Lights::KeepBlur,
            ..default
        };
    }
    let noise = &settings.noise;
    Deconvolver {
        noise: noise.get(index).or(noise.first()).copied(),
        saturation: settings.saturation,
        ..default
    }
}

impl RemovedPlate {
    /// Brings the colours of a removal from scaled light back to the light of the plate.
    fn restore(&mut self, scale: LightScale) {
        for plane in &mut self.planes[..self.colour_count] {
            scale.restore(&mut plane.sharp);
            scale.restore(&mut plane.residual);
            plane.noise /= scale.factor();
            if let Some(clipping) = &mut plane.clipping {
                clipping.level /= scale.factor();
            }
        }
    }

    /// Checks that all results are finite; the planes have `names`.
    fn check(&self, names: &[String]) -> Result<()> {
        for (index, (plane, name)) in self.planes.iter().zip(names).enumerate() {
            let canvas = plane.canvas;
            let maps = [&plane.residual, &plane.confidence];
            let maps = maps.into_iter().chain(self.noise_gain.get(index));
            let maps = maps.map(|samples| (samples, canvas.plate.0, [0; 2]));
            let first = [canvas.margin_x, canvas.margin_y].map(|margin| -(margin as i64));
            let sharp = (&plane.sharp, canvas.size().0, first);
            for (samples, width, first) in [sharp].into_iter().chain(maps) {
                let computed = ComputedPlane {
                    name: format!("channel {name}"),
                    samples,
                    width,
                    first,
                };
                computed.check()?;
            }
        }
        Ok(())
    }

    /// The solution of each colour plane.
    pub fn colours(&self) -> &[SharpPlane] {
        &self.planes[..self.colour_count]
    }

    /// The place of the plate on the canvas, the same for all planes.
    ///
    /// # Errors
    /// A plate without planes.
    pub fn canvas(&self) -> Result<Canvas> {
        let first = self.planes.first().map(|removed| removed.canvas);
        first.ok_or_else(|| Error::new("plate", "has no planes", "give at least one colour"))
    }

    /// Standard deviation of the noise of each plane.
    pub fn noise(&self) -> Vec<f64> {
        self.planes.iter().map(|removed| removed.noise).collect()
    }

    /// Whether the background was of use: foreground and background were solved by themselves. Otherwise there is none, or the
    /// plate is nowhere nearer than it by a layer of depth.
    pub fn is_split(&self) -> bool {
        self.is_split
    }

    /// Amplification of noise at each pixel of the plate, one plane a colour; empty unless measured.
    pub fn noise_gain(&self) -> &[Vec<f32>] {
        &self.noise_gain
    }

    /// Share of each pixel's detail that the plate determines, 0 to 1, one plane a colour.
    pub fn confidence(&self) -> Vec<Vec<f32>> {
        let colours = self.colours().iter();
        colours.map(|removed| removed.confidence.clone()).collect()
    }

    /// Returns the sharp premultiplied planes on the canvas, with grain and at the strength that the settings of `plate`
    /// ask for.
    ///
    /// # Errors
    /// A plate without planes.
    pub fn sharp_planes(&self, plate: &PreparedPlate) -> Result<Vec<Vec<f32>>> {
        let settings = &plate.session().settings().removal;
        let canvas = self.canvas()?;
        let mut planes = self.solution();
        if settings.grain == Grain::Keep {
            self.add_grain(&mut planes, |removed| removed.grain());
        }
        let strength = settings.strength as f32;
        if strength < 1.0 {
            for (plane, before) in planes.iter_mut().zip(plate.planes()) {
                for (sample, before) in plane.iter_mut().zip(canvas.extend_by_replication(before)) {
                    *sample = before + strength * (*sample - before);
                }
            }
        }
        Ok(planes)
    }

    /// Returns the sharp image, cropped to the plate.
    ///
    /// # Errors
    /// A plate without planes.
    pub fn sharp_image(&self, plate: &PreparedPlate) -> Result<Image> {
        let canvas = self.canvas()?;
        let planes = self.sharp_planes(plate)?;
        let cropped = planes.iter().map(|plane| canvas.crop(plane)).collect();
        plate.to_image(cropped)
    }

    /// Returns the premultiplied planes of `plate`, from which blur was removed, as the lens of `other` renders the solution. `other`
    /// is the same plate prepared for another lens, whose sensor records the result.
    ///
    /// With R and S the solution rendered through the two lenses, and m the change from R to S
    /// ([`change_map`]), a plane b of the plate becomes S + (1 - m) (b - R) + m g, where g is its grain. So what both lenses share stays
    /// as it is, to the bit where they are one lens.
    ///
    /// # Errors
    /// Those of [`PreparedPlate::apply`].
    pub fn apply_other(
        &self,
        plate: &PreparedPlate,
        other: &PreparedPlate,
        progress: &Progress,
    ) -> Result<Vec<Vec<f32>>> {
        let before = self.render(plate, &|share| progress(0.5 * share))?;
        let mut planes = self.render(other, &|share| progress(0.5 + 0.5 * share))?;
        let [now, was] = [&planes, &before].map(|planes| {
            let slices = planes.iter().map(Vec::as_slice);
            slices.collect::<Vec<_>>()
        });
        let changes = change_map(&now, &was, &self.noise())?;
        let light = plate.undeveloped();
        let samples = planes.iter_mut().zip(light.planes()).zip(&before);
        for (((out, plate), before), removed) in samples.zip(&self.planes) {
            let grain = removed.canvas.crop(&removed.grain());
            let pixels = out.par_iter_mut().zip(plate).zip(before);
            let pixels = pixels.zip(&changes).zip(&grain);
            pixels.for_each(|((((out, plate), before), change), grain)| {
                *out += (1.0 - change) * (plate - before) + change * grain;
            });
        }
        self.clamp_alpha(&mut planes);
        other.develop(&mut planes);
        Ok(planes)
    }

    /// Returns the solution as the lens of `plate` renders it, cropped to the plate.
    fn render(&self, plate: &PreparedPlate, progress: &Progress) -> Result<Vec<Vec<f32>>> {
        let canvas = self.canvas()?;
        let light = plate.premultiplied().with_planes(self.solution());
        let reduced = light.reduced();
        let light = reduced.as_ref().map_or(&light, |r| &r.planes);
        let mut blurred = plate.with_optics(|optics| {
            let pass = match optics.scene.vergence {
                VergencePass::PerPixel(pass) => Some(canvas.extend_by_replication(pass)),
                VergencePass::Constant(_) => None,
            };
            let rendering = Rendering {
                scene: &canvas.scene(&optics.scene, pass.as_deref()),
                planes: &light.weighted(plate.weights()),
                occlusion: Some(Occlusion::default()),
                edges: Edges::Mirror,
                renderer: &Gather::default(),
                quality: Quality::Final,
            };
            Ok(rendering.render(None, progress)?.planes)
        })?;
        if let Some(reduced) = &reduced {
            let colours = blurred.iter_mut().take(self.colour_count);
            colours.for_each(|plane| reduced.scale.restore(plane));
        }
        let mut planes: Vec<_> = blurred.iter().map(|plane| canvas.crop(plane)).collect();
        self.clamp_alpha(&mut planes);
        Ok(planes)
    }

    /// The solution on the canvas, alpha within 0..1.
    fn solution(&self) -> Vec<Vec<f32>> {
        let mut planes: Vec<Vec<f32>> = (self.planes.iter())
            .map(|removed| removed.sharp.clone())
            .collect();
        self.clamp_alpha(&mut planes);
        planes
    }

    fn clamp_alpha(&self, planes: &mut [Vec<f32>]) {
        let alphas = planes.iter_mut().skip(self.colour_count);
        for sample in alphas.flatten() {
            *sample = sample.clamp(0.0, 1.0);
        }
    }

    fn add_grain(&self, planes: &mut [Vec<f32>], grain: impl Fn(&SharpPlane) -> Vec<f32>) {
        for (plane, removed) in planes.iter_mut().zip(self.colours()) {
            let grain = grain(removed);
            plane
                .par_iter_mut()
                .zip(&grain)
                .for_each(|(sample, grain)| *sample += grain);
        }
    }
}
