//! Occlusion on top of any renderer: near over far, and what a blurred foreground uncovers.
//!
//! The plate is cut into slices of nearly equal blur (`layers`, `slices`), each is blurred on its own
//! by the inner renderer together with its *presence*, one for every pixel, and the slices are put
//! behind each other from the nearest on (`resolve`). What lies behind near sides of depth edges is
//! guessed (`hidden`, `pyramid`); anti-aliased edges of the depth pass are made sharp (`depth_edges`), those
//! of the plate are shared out to both sides (`mixed`).

mod depth_edges;
mod depth_layers;
mod hidden;
mod mixed;
mod pyramid;
mod resolve;
mod slices;
#[cfg(test)]
mod tests;

pub use hidden::HIDDEN_REACH_PX;

use crate::{
    Edges, Plane, RenderStatistics, RenderWindow, Rendered, Renderer, Scene, VergencePass,
    cancelled,
};
pub(crate) use depth_layers::{DepthLayers, LayerSpacing};
use hidden::{HiddenInput, HiddenRow};
use rayon::prelude::*;
use resolve::{Blurred, Resolve, Sharp};
use seidel_optics::error::{Error, Result};
use slices::Stock;

/// Something that is put in front later: what lies behind it is kept back, sharp to the pixel.
#[derive(Debug, Clone, Copy)]
pub struct Holdout<'a> {
    /// How much is kept back of each pixel, row-major, 0 to 1.
    pub matte: &'a [f32],
    /// Where it is; only what is farther is kept back. `None`: everything is. Things within about 8 % of its
    /// vergence are neither wholly before nor wholly behind it.
    pub vergence: Option<VergencePass<'a>>,
}

/// How depth edges are treated.
#[derive(Debug, Clone, Copy)]
pub struct Occlusion<'a> {
    /// Whether what a blurred foreground uncovers is filled with what can be seen beside it. If not, it
    /// is filled with what the blur brings there, the foreground's own light for the most part.
    pub fill_foreground: bool,
    /// Whether a blurred foreground becomes transparent within its own outline. If not, nothing shows
    /// through there: it is blurred outwards only, and its outline stays hard.
    pub blur_inside: bool,
    /// Something that will be in front.
    pub holdout: Option<Holdout<'a>>,
}

impl Default for Occlusion<'_> {
    fn default() -> Self {
        Self {
            fill_foreground: true,
            blur_inside: true,
            holdout: None,
        }
    }
}

/// A renderer that lets near things hide far ones, on top of one that need not know depth.
///
/// Plates at constant vergence are rendered by the inner renderer alone. On others the brightness of
/// even surfaces is kept, rather than the sum of light.
#[derive(Clone, Copy)]
pub struct LayeredRenderer<'r> {
    /// Blurs the slices.
    pub inner: &'r dyn Renderer,
    /// How depth edges are treated.
    pub settings: Occlusion<'r>,
}

impl Renderer for LayeredRenderer<'_> {
    fn id(&self) -> &'static str {
        "layers"
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
        self.settings.check(scene)?;
        let mut rendered = match scene.vergence {
            VergencePass::Constant(vergence) => {
                let mut rendered = self.inner.render(scene, planes, progress)?;
                self.settings.hold_out(vergence, &mut rendered.planes);
                rendered
            }
            VergencePass::PerPixel(pass) if !planes.is_empty() => {
                self.render_layers(scene, pass, planes, progress)?
            }
            VergencePass::PerPixel(_) => Rendered {
                planes: Vec::new(),
                statistics: RenderStatistics::default(),
            },
        };
        rendered.planes = window.cut_planes(scene, rendered.planes);
        Ok(rendered)
    }
}

impl Occlusion<'_> {
    fn check(&self, scene: &Scene) -> Result<()> {
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

    /// Keeps back what is to be kept back of planes that are all at one vergence.
    fn hold_out(&self, vergence: f64, planes: &mut [Vec<f32>]) {
        let Some(holdout) = self.holdout else {
            return;
        };
        for plane in planes {
            for (index, sample) in plane.iter_mut().enumerate() {
                *sample *= holdout.passing(vergence, index);
            }
        }
    }
}

impl Holdout<'_> {
    /// How much of something at `vergence` is not kept back at pixel `index`.
    fn passing(&self, vergence: f64, index: usize) -> f32 {
        let behind = match self.vergence {
            None => true,
            Some(VergencePass::Constant(at)) => vergence < at,
            Some(VergencePass::PerPixel(pass)) => vergence < f64::from(pass[index]),
        };
        if behind { 1.0 - self.matte[index] } else { 1.0 }
    }
}

type Planes = Vec<Vec<f32>>;

impl LayeredRenderer<'_> {
    fn render_layers(
        &self,
        scene: &Scene,
        pass: &[f32],
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        let fold = |start: f32, pick: fn(f32, f32) -> f32| pass.iter().copied().fold(start, pick);
        let (least, largest) = (
            fold(f32::INFINITY, f32::min),
            fold(f32::NEG_INFINITY, f32::max),
        );
        // What a holdout is in front of may be as blurred as what it is behind.
        let spacing = match self.settings.holdout {
            Some(Holdout {
                vergence: Some(_), ..
            }) => LayerSpacing::Fine,
            _ => LayerSpacing::ByBlur,
        };
        let layers = DepthLayers::new(scene, f64::from(least), f64::from(largest), spacing);
        let places: Vec<f32> = pass
            .par_iter()
            .map(|v| layers.coordinate(f64::from(*v)))
            .collect();
        let places = depth_edges::snapped(&places, scene.width, scene.height);
        let input = HiddenInput {
            width: scene.width,
            height: scene.height,
            origin: hidden::grid_origin(scene.map),
            places: &places,
            planes,
        };
        let go_on = || match progress(0.0) {
            true => Ok(()),
            false => Err(cancelled()),
        };
        go_on()?;
        let mixed = mixed::shared_out(&input);
        go_on()?;
        let sheet = self.sheet(&input, &layers, &|| progress(0.0));
        let sheet = sheet.ok_or_else(cancelled)?;
        let hard = (!self.settings.blur_inside).then(|| covered(&sheet, scene.width));
        let stock = Stock {
            planes,
            places: &places,
            further: if self.settings.fill_foreground {
                &[&mixed, &sheet]
            } else {
                &[&mixed]
            },
            width: scene.width,
        };
        let sharp = Sharp {
            holdout: self.settings.holdout,
            hard: hard.as_deref().map(|hard| (&places[..], hard)),
        };
        let views = Views::new(planes);
        let size = (scene.width, scene.height);
        let mut resolve = Resolve::new(size, views.mix.clone(), views.view_of.clone());
        let crops = stock.crops(scene, &layers);
        let count = crops.iter().flatten().count() as f64;
        let mut statistics = RenderStatistics {
            layers: crops.iter().filter(|crops| !crops.is_empty()).count(),
            ..RenderStatistics::default()
        };
        let nearest_first = crops.iter().enumerate().rev();
        let all =
            nearest_first.flat_map(|(layer, crops)| crops.iter().map(move |crop| (layer, *crop)));
        for (done, (layer, crop)) in all.enumerate() {
            let vergence = layers.vergence(layer);
            let progress = |share: f64| progress((done as f64 + share) / count);
            let slice = stock.slice(layers.coordinate_of(layer), crop);
            let cropped = slices::cropped(scene, crop, vergence);
            let (blurred, presence) =
                self.blur(&cropped, &views, planes, slice, &progress, &mut statistics)?;
            let blurred = Blurred {
                layer,
                place: layers.coordinate_of(layer),
                vergence,
                crop,
                planes: &blurred,
                presence: &presence,
            };
            resolve.put(&blurred, &sharp);
        }
        Ok(Rendered {
            planes: resolve.finish(),
            statistics,
        })
    }

    /// What is behind near sides of edges, if it is needed.
    fn sheet(
        &self,
        input: &HiddenInput,
        layers: &DepthLayers,
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Option<Vec<HiddenRow>> {
        if !self.settings.fill_foreground && self.settings.blur_inside {
            return Some(Vec::new());
        }
        hidden::sheet(input, layers, goes_on)
    }

    /// Planes and presence planes of one slice, blurred.
    fn blur(
        &self,
        scene: &Scene,
        views: &Views,
        planes: &[Plane],
        (samples, presence): (Planes, Vec<f32>),
        progress: &(dyn Fn(f64) -> bool + Sync),
        statistics: &mut RenderStatistics,
    ) -> Result<(Planes, Planes)> {
        let light = samples.iter().zip(planes).map(|(samples, plane)| Plane {
            samples,
            weights: plane.weights,
        });
        let presences = views.presence_weights.iter().map(|weights| Plane {
            samples: &presence,
            weights,
        });
        if scene.edges == Edges::Mirror {
            let all: Vec<_> = light.chain(presences).collect();
            let mut done = self.inner.render(scene, &all, progress)?;
            statistics.add_part(&done.statistics);
            let presence = done.planes.split_off(planes.len());
            return Ok((done.planes, presence));
        }
        // Light may leave the plate; that is no reason to make up for it. Presence stays.
        let light: Vec<_> = light.collect();
        let presences: Vec<_> = presences.collect();
        let done = self
            .inner
            .render(scene, &light, &|done| progress(0.5 * done))?;
        let mirrored = Scene {
            edges: Edges::Mirror,
            ..*scene
        };
        let presence = self
            .inner
            .render(&mirrored, &presences, &|done| progress(0.5 + 0.5 * done))?;
        statistics.add_part(&done.statistics);
        statistics.add_part(&presence.statistics);
        Ok((done.planes, presence.planes))
    }
}

/// How much is known to be behind every pixel.
fn covered(sheet: &[HiddenRow], width: usize) -> Vec<f32> {
    let mut out = vec![0.0; sheet.len() * width];
    for (row, line) in sheet.iter().zip(out.chunks_exact_mut(width)) {
        for (column, weight) in row.columns.iter().zip(&row.weights) {
            line[*column as usize] = *weight;
        }
    }
    out
}

/// The distinct channel weights of planes, and the presence planes that they need.
struct Views {
    /// View of each plane.
    view_of: Vec<usize>,
    /// Channel weights of the presence planes.
    presence_weights: Vec<Vec<f64>>,
    /// For each view, shares of the presence planes.
    mix: Vec<Vec<f32>>,
}

impl Views {
    fn new(planes: &[Plane]) -> Self {
        let mut views: Vec<&[f64]> = Vec::new();
        let view = |plane: &Plane<'_>, views: &mut Vec<&[f64]>| {
            views.iter().position(|view| *view == plane.weights)
        };
        let mut view_of = Vec::with_capacity(planes.len());
        for plane in planes {
            let index = view(plane, &mut views).unwrap_or(views.len());
            if index == views.len() {
                views.push(plane.weights);
            }
            view_of.push(index);
        }
        let channels = views.first().map_or(0, |view| view.len());
        let used: Vec<usize> = (0..channels)
            .filter(|&channel| views.iter().any(|view| view[channel] != 0.0))
            .collect();
        let of = |index: usize, size: usize| {
            let mut unit = vec![0.0; size];
            unit[index] = 1.0;
            unit
        };
        // Blur is linear: presence as several channels see it together is the sum of theirs.
        if used.len() < views.len() {
            let pick = |view: &&[f64]| used.iter().map(|&k| view[k] as f32).collect();
            return Self {
                view_of,
                presence_weights: used.iter().map(|&k| of(k, channels)).collect(),
                mix: views.iter().map(pick).collect(),
            };
        }
        let count = views.len();
        Self {
            view_of,
            presence_weights: views.iter().map(|view| view.to_vec()).collect(),
            mix: (0..count)
                .map(|k| of(k, count).into_iter().map(|v: f64| v as f32).collect())
                .collect(),
        }
    }
}
