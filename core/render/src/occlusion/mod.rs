//! Occlusion on top of any renderer: near over far, with disocclusion fill.
//!
//! The plate is cut into depth layers of nearly equal blur (`depth_layers`, `layer_samples`). The inner renderer blurs
//! each layer together with its *presence*, one at every pixel of the layer. The layers are composited from the nearest
//! to the farthest (`composite`). Samples hidden behind near sides of depth edges are estimated (`disocclusion`,
//! `cell_pyramid`, `hidden_texture`). Anti-aliased edges of the depth pass are made sharp (`depth_edges`); those of the plate are split
//! between both sides (`mixed_pixels`). Small bright lights are taken out of the plate, blurred at their own depth and cut by what is
//! nearer (`small_lights`).

mod background;
mod blur_map;
mod cell_pyramid;
mod composite;
mod depth_edges;
mod depth_layers;
mod disocclusion;
mod edge_distance;
mod extra_samples;
mod farthest_nearby;
mod hidden_texture;
mod layer_samples;
mod layer_stack;
mod layer_waves;
mod layered_plate;
mod mixed_pixels;
mod other_sides;
mod small_lights;
#[cfg(test)]
mod tests;

pub use background::Background;
pub use blur_map::{BlurMap, DepthSlice, FocusSide};
pub(crate) use depth_edges::snapped;
pub(crate) use depth_layers::{DepthLayers, LayerSpacing};
pub use disocclusion::HIDDEN_REACH_PX;
pub(crate) use mixed_pixels::far_part;
pub use other_sides::OtherSides;

use crate::{
    Plane, RenderStatistics, RenderWindow, Rendered, Renderer, Scene, VergencePass, cancelled,
};
use composite::{Outline, SharpMattes};
use extra_samples::ExtraSamples;
use layer_samples::LayerSource;
use layer_stack::{LayerBlur, LayerStack};
use layered_plate::LayeredPlate;
use mixed_pixels::{CleanPlate, MixedPixels};
use rayon::prelude::*;
use seidel_optics::error::{Error, Result};
use small_lights::{LightCells, LightCut, SignedBlur, SmallLights};

/// A holdout: an object composited in front later, whose matte holds back what lies behind it without blur.
#[derive(Debug, Clone, Copy)]
pub struct Holdout<'a> {
    /// Share of each pixel held back, row-major, 0 to 1.
    pub matte: &'a [f32],
    /// Vergence of the object; it holds back only what is farther. `None` holds back everything. Surfaces within about
    /// 8 % of its vergence are partly in front and partly behind.
    pub vergence: Option<VergencePass<'a>>,
}

/// The treatment of depth edges.
#[derive(Debug, Clone, Copy)]
pub struct Occlusion<'a> {
    /// Whether areas uncovered by a blurred foreground are filled with the background visible beside it. If not, they
    /// are filled with whatever light blur brings there, mostly the foreground's own.
    pub fill_foreground: bool,
    /// Whether a blurred foreground becomes transparent within its own outline. If not, it is blurred outwards only and
    /// its outline stays hard.
    pub blur_inside: bool,
    /// An object composited in front later.
    pub holdout: Option<Holdout<'a>>,
    /// The background: shown where the foreground is taken away. It replaces the fill of uncovered areas.
    pub background: Option<Background<'a>>,
    /// Pixels whose light is divided between two sides already.
    pub other_sides: Option<OtherSides<'a>>,
    /// The plate without the black margin about it, whose pixels have the depth of the nearest one; `None` if it has no such margin.
    pub own: Option<RenderWindow>,
    /// Number of planes that hold light. Those after them hold coverage, in which a bright pixel is no light; `None` if all hold light.
    pub light_planes: Option<usize>,
}

impl Default for Occlusion<'_> {
    fn default() -> Self {
        Self {
            fill_foreground: true,
            blur_inside: true,
            holdout: None,
            background: None,
            other_sides: None,
            own: None,
            light_planes: None,
        }
    }
}

/// A renderer in which near surfaces hide far ones, on top of an inner renderer for one vergence.
///
/// The inner renderer alone renders plates of constant vergence. On others the brightness of even surfaces is kept,
/// not the sum of light.
#[derive(Clone, Copy)]
pub struct LayeredRenderer<'r> {
    /// Renderer of each depth layer.
    pub inner: &'r dyn Renderer,
    /// Treatment of depth edges.
    pub settings: Occlusion<'r>,
}

impl Renderer for LayeredRenderer<'_> {
    fn id(&self) -> &'static str {
        "layers"
    }

    fn overshoot(&self) -> f32 {
        self.inner.overshoot()
    }

    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        scene.check(planes)?;
        window.check(scene)?;
        self.settings.check(scene, planes.len())?;
        match scene.vergence {
            VergencePass::Constant(vergence) => {
                let mut rendered = self.inner.render_window(scene, planes, window, progress)?;
                let held = &mut rendered.planes;
                self.settings.hold_out(vergence, scene.width, window, held);
                Ok(rendered)
            }
            VergencePass::PerPixel(pass) if !planes.is_empty() => {
                self.render_layers(scene, pass, planes, window, progress)
            }
            VergencePass::PerPixel(_) => Ok(Rendered {
                planes: Vec::new(),
                statistics: RenderStatistics::default(),
            }),
        }
    }
}

impl Occlusion<'_> {
    pub(crate) fn check(&self, scene: &Scene, planes: usize) -> Result<()> {
        if let Some(background) = self.background {
            background.check(scene, planes)?;
        }
        if let Some(sides) = self.other_sides {
            sides.check(scene)?;
        }
        let Some(holdout) = self.holdout else {
            return Ok(());
        };
        let mut passes = vec![("holdout matte", holdout.matte)];
        if let Some(VergencePass::PerPixel(pass)) = holdout.vergence {
            passes.push(("holdout depth", pass));
        }
        for (name, pass) in passes {
            if pass.len() != scene.pixel_count() {
                return Err(Error::new(
                    name,
                    format!("has {} samples", pass.len()),
                    format!(
                        "give one a pixel of the {} x {} plate",
                        scene.width, scene.height
                    ),
                ));
            }
            if let Some(index) = pass.iter().position(|sample| !sample.is_finite()) {
                return Err(Error::new(
                    format!(
                        "{name}, pixel ({}, {})",
                        index % scene.width,
                        index / scene.width
                    ),
                    format!("is {}", pass[index]),
                    "replace values that are not finite",
                ));
            }
        }
        Ok(())
    }

    /// Applies the holdout to planes at one vergence, in a `window` of a plate of `width` columns.
    fn hold_out(&self, vergence: f64, width: usize, window: RenderWindow, planes: &mut [Vec<f32>]) {
        let Some(holdout) = self.holdout else {
            return;
        };
        for plane in planes {
            for (line, row) in plane.chunks_exact_mut(window.width).zip(window.row..) {
                let first = row * width + window.column;
                for (sample, index) in line.iter_mut().zip(first..) {
                    *sample *= holdout.transmittance(vergence, index);
                }
            }
        }
    }
}

impl Holdout<'_> {
    /// Returns the share of light at `vergence` that passes at pixel `index`.
    fn transmittance(&self, vergence: f64, index: usize) -> f32 {
        let behind = match self.vergence {
            None => true,
            Some(VergencePass::Constant(at)) => vergence < at,
            Some(VergencePass::PerPixel(pass)) => vergence < f64::from(pass[index]),
        };
        if behind { 1.0 - self.matte[index] } else { 1.0 }
    }
}

impl LayeredRenderer<'_> {
    fn render_layers(
        &self,
        scene: &Scene,
        pass: &[f32],
        planes: &[Plane],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        let all = || pass.par_iter().copied();
        let (mut least, mut largest) = (
            f64::from(all().reduce(|| f32::INFINITY, f32::min)),
            f64::from(all().reduce(|| f32::NEG_INFINITY, f32::max)),
        );
        if let Some(background) = &self.settings.background {
            let (low, high) = background.vergence_range();
            (least, largest) = (least.min(low), largest.max(high));
        }
        // A holdout separates surfaces that may be equally blurred.
        let holdout = self.settings.holdout;
        let spacing = LayerSpacing {
            is_fine: holdout.is_some_and(|holdout| holdout.vergence.is_some()),
            ..LayerSpacing::BY_BLUR
        };
        let layers = DepthLayers::new(scene, least, largest, spacing);
        let coordinates = {
            let of_pass: Vec<f32> = pass
                .par_iter()
                .map(|v| layers.coordinate(f64::from(*v)))
                .collect();
            depth_edges::snapped(&of_pass, scene.width, scene.height)
        };
        let light_planes = self.settings.light_planes.unwrap_or(planes.len());
        let light_planes = light_planes.min(planes.len());
        let whole = LayeredPlate {
            width: scene.width,
            height: scene.height,
            origin: disocclusion::grid_origin(scene),
            known: match self.settings.own {
                // Where there is coverage, a margin is known to be uncovered.
                Some(own) if light_planes == planes.len() => own,
                _ => RenderWindow::whole(scene),
            },
            coordinates: &coordinates,
            planes,
            light_count: light_planes,
        };
        let blur = SignedBlur::new(scene, &layers);
        let mixed_pixels = MixedPixels::new(&whole);
        let light_cells = if self.inner.is_preview() {
            LightCells::COARSE
        } else {
            LightCells::FINE
        };
        let small_lights = SmallLights::find(&whole, &mixed_pixels, &layers, &blur, light_cells);
        let rest = small_lights.rest(planes);
        let planes = rest.as_slice();
        let input = LayeredPlate { planes, ..whole };
        let check_cancelled = || {
            if progress(0.0) {
                Ok(())
            } else {
                Err(cancelled())
            }
        };
        check_cancelled()?;
        let background = self.settings.background.as_ref();
        let clean = background.map(|background| CleanPlate {
            background,
            layers: &layers,
            with_lights: &whole,
        });
        let corrections = mixed_pixels.corrections(&input, clean.as_ref());
        // As large as the plate.
        drop(mixed_pixels);
        check_cancelled()?;
        let hidden = self.hidden_samples(&input, &layers, &|| progress(0.0));
        let hidden = hidden.ok_or_else(cancelled)?;
        let held = (!self.settings.blur_inside).then(|| presence_of(&hidden, scene.width));
        let divided = self.settings.other_sides.as_ref();
        let divided = divided.map(|sides| sides.samples(&input, &layers));
        let is_filled = self.settings.fill_foreground || self.settings.background.is_some();
        let extra: Vec<&[ExtraSamples]> = [Some(&corrections), divided.as_ref()]
            .into_iter()
            .chain([is_filled.then_some(&hidden)])
            .flatten()
            .map(Vec::as_slice)
            .collect();
        let source = LayerSource {
            planes,
            coordinates: &coordinates,
            extra: &extra,
            width: scene.width,
        };
        let mattes = SharpMattes {
            holdout: self.settings.holdout,
            outline: held.as_deref().map(|held| Outline {
                coordinates: &coordinates,
                held,
            }),
        };
        let stack = LayerStack {
            scene,
            layers: &layers,
            source: &source,
            mattes: &mattes,
            blur: LayerBlur::new(self.inner, scene, planes),
        };
        let (mut rendered, mut statistics) = stack.render(window, progress)?;
        statistics.highlights += small_lights.pixel_count();
        for (out, plane) in rendered.iter_mut().zip(planes) {
            remove_overshoot(out, plane.samples, self.inner.overshoot());
        }
        let cut = LightCut {
            scene,
            window,
            layers: &layers,
            blur: &blur,
            coordinates: &coordinates,
            planes: &planes[..light_planes],
        };
        let transmittance = |vergence: f64, coordinate: f32, index: usize| {
            mattes.transmittance(vergence, coordinate, index)
        };
        small_lights.add_to(
            &mut rendered[..light_planes],
            &cut,
            &transmittance,
            progress,
        )?;
        if small_lights.pixel_count() > 0 {
            // Lights are added to the composite. It is an average of samples, with its lights too.
            for (out, plane) in rendered[..light_planes].iter_mut().zip(whole.planes) {
                limit_to_brightest(out, plane.samples);
            }
        }
        Ok(Rendered {
            planes: rendered,
            statistics,
        })
    }

    /// Returns the samples hidden behind near sides of edges, given or estimated, if the settings need them; `None` once `goes_on` returns
    /// false.
    fn hidden_samples(
        &self,
        input: &LayeredPlate,
        layers: &DepthLayers,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Option<Vec<ExtraSamples>> {
        if let Some(background) = &self.settings.background {
            return Some(background.hidden_samples(input, layers));
        }
        if !self.settings.fill_foreground && self.settings.blur_inside {
            return Some(Vec::new());
        }
        disocclusion::hidden_samples(input, layers, goes_on)
    }
}

/// Limits results to the brightest of `samples`.
fn limit_to_brightest(out: &mut [f32], samples: &[f32]) {
    let brightest = samples.par_iter().copied().reduce(|| 0.0, f32::max);
    out.par_iter_mut()
        .for_each(|value| *value = value.min(brightest));
}

/// Moves results outside the range of `samples` and black to its ends, where they are beyond it by no more than `overshoot` of the
/// brightest light: a composite is an average of samples and black.
fn remove_overshoot(out: &mut [f32], samples: &[f32], overshoot: f32) {
    let range = samples.par_iter().fold(
        || [0.0_f32; 2],
        |[least, most], sample| [least.min(*sample), most.max(*sample)],
    );
    let [least, most] = range.reduce(|| [0.0; 2], |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    let largest = overshoot * most.max(-least);
    out.par_iter_mut().for_each(|value| {
        let nearest = value.clamp(least, most);
        if (*value - nearest).abs() <= largest {
            *value = nearest;
        }
    });
}

/// Returns the presence of hidden samples at every pixel.
fn presence_of(hidden: &[ExtraSamples], width: usize) -> Vec<f32> {
    let mut out = vec![0.0; hidden.len() * width];
    for (row, line) in hidden.iter().zip(out.chunks_exact_mut(width)) {
        for (column, weight) in row.columns.iter().zip(&row.weights) {
            line[*column as usize] = *weight;
        }
    }
    out
}
