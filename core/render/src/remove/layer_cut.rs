//! The cut of a canvas into depth layers, and the light that passes from one to the next.

use super::depth_layer::DepthLayer;
use super::gradient::Links;
use super::hidden_surface::HiddenSurface;
use super::transfer_functions::Purpose;
use crate::{DepthLayers, LayerSpacing, RenderWindow, Scene, snapped};
use rayon::prelude::*;
use seidel_optics::error::Result;

/// Least light of a blurred uniform canvas that is normalised to one. A lower bound would amplify pixels that get hardly
/// any light.
const MIN_UNIFORM_LIGHT: f32 = 0.3;

/// The additional parts of a canvas with depth.
pub(super) struct Depth {
    /// The diagonal of G.
    pub(super) gains: Vec<f32>,
    pub(super) surface: HiddenSurface,
    /// The links of the image of front and back, one above the other.
    pub(super) links: Links,
    /// Share of each pixel's light that comes from behind an edge or is hidden by one.
    pub(super) edge_light: Vec<f32>,
}

/// A canvas cut into layers by the vergence of each of its pixels.
pub(super) struct LayerCut {
    layers: DepthLayers,
    /// Layer coordinates of the surfaces in front.
    coordinates: Vec<f32>,
    surface: HiddenSurface,
    /// Nearness of each layer.
    nearness: Vec<f32>,
}

impl LayerCut {
    pub(super) fn new(scene: &Scene, pass: &[f32]) -> Self {
        let ends = |(low, high): (f32, f32), v: &f32| (low.min(*v), high.max(*v));
        let (lowest, highest) = pass.iter().fold((f32::INFINITY, f32::NEG_INFINITY), ends);
        let (lowest, highest) = (f64::from(lowest), f64::from(highest));
        let layers = DepthLayers::new(scene, lowest, highest, LayerSpacing::BY_HALF_THE_BLUR);
        let coordinates: Vec<f32> = pass
            .par_iter()
            .map(|vergence| layers.coordinate(f64::from(*vergence)))
            .collect();
        let coordinates = snapped(&coordinates, scene.width, scene.height);
        let size = |index: usize| layers.size(layers.coordinate_of(index));
        let mut nearness = vec![0.0];
        for index in 1..layers.len() {
            let last = nearness[index - 1];
            nearness.push(last + (size(index) - size(index - 1)).abs());
        }
        let nearness_at = |coordinate: &f32| {
            let (low, high) = layers.around(*coordinate);
            let share = coordinate - layers.coordinate_of(low);
            nearness[low] + share * (nearness[high] - nearness[low])
        };
        let front = coordinates.iter().map(nearness_at).collect();
        let largest = coordinates.iter().map(|at| layers.size(*at));
        // Kernels of the hidden surface reach across the edge from one side, and those of the near surface from the other.
        let whole_plate = (scene.width + scene.height) as f32;
        let reach = 2.0 * largest.fold(0.0, f32::max);
        let reach = reach.min(whole_plate).ceil() as usize + 2;
        Self {
            surface: HiddenSurface::new(front, scene.width, reach),
            layers,
            coordinates,
            nearness,
        }
    }

    /// Returns the vergence and the coverage of each layer that pixels show.
    pub(super) fn coverages(&self) -> impl Iterator<Item = (f64, Vec<f32>)> + '_ {
        let layers = (0..self.layers.len()).map(|k| (self.layers.vergence(k), self.coverage(k)));
        layers.filter(|(_, coverage)| coverage.iter().any(|share| *share > 0.0))
    }

    /// Returns the share of each pixel of the canvas that is in a layer.
    fn coverage(&self, index: usize) -> Vec<f32> {
        let hat = |at: &f32| (1.0 - (at - self.layers.coordinate_of(index)).abs()).max(0.0);
        self.coordinates.iter().map(hat).collect()
    }

    /// Returns the layers with a pixel in them, without transmissions.
    pub(super) fn layers(
        &self,
        scene: &Scene,
        weights: &[f64],
        purpose: Purpose,
    ) -> Result<Vec<DepthLayer>> {
        let layer = |index: usize| {
            let coverage = self.coverage(index);
            let behind = |k: usize| {
                let source = self.surface.source(k);
                source.map_or(0.0, |source| coverage[source])
            };
            let hidden: Vec<f32> = (0..coverage.len()).map(behind).collect();
            let either: Vec<f32> = coverage.iter().zip(&hidden).map(|(a, b)| a + b).collect();
            let covered = covered_window(&either, scene.width)?;
            let vergence = self.layers.vergence(index);
            let layer =
                DepthLayer::at_vergence(scene, weights, purpose, vergence, covered, &coverage);
            Some(layer.map(|layer| layer.with_hidden(&hidden, self.nearness[index])))
        };
        (0..self.layers.len())
            .into_par_iter()
            .filter_map(layer)
            .collect()
    }

    /// Sets the transmissions of all `layers` of a canvas of `size`.
    pub(super) fn depth(self, layers: &mut [DepthLayer], size: (usize, usize)) -> Result<Depth> {
        let count = size.0 * size.1;
        let surface = &self.surface;
        let image_of = |front: f32, hidden: f32| {
            let mut image = vec![front; count];
            image.resize(2 * count, hidden);
            image
        };
        let limits: Vec<Option<f32>> = (0..count).map(|k| surface.hiding_limit(k)).collect();
        let hides = |limit: &Option<f32>| f32::from(u8::from(limit.is_some()));
        let mut in_front: Vec<f32> = limits.iter().map(hides).collect();
        in_front.resize(2 * count, 0.0);
        let largest_limits: Vec<Option<f32>> = (layers.iter())
            .map(|layer| layer.largest_covered(&limits))
            .collect();
        let blur = |image: &[f32]| -> Result<Vec<Vec<f32>>> {
            layers.par_iter().map(|layer| layer.apply(image)).collect()
        };
        let covered = blur(&image_of(1.0, 0.0))?;
        let behind = blur(&image_of(0.0, 1.0))?;
        let hiding = blur(&in_front)?;
        let transmissions: Vec<Vec<f32>> = (layers.par_iter())
            .map(|layer| {
                let mut passed = vec![1.0; count];
                for ((nearer, covered), limit) in layers.iter().zip(&hiding).zip(&largest_limits) {
                    let share = |limit| HiddenSurface::hiding(limit, layer.nearness());
                    match limit.map_or(0.0, share) {
                        0.0 => {}
                        share => nearer.add_scaled_to(&mut passed, covered, -share),
                    }
                }
                passed.iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0));
                passed
            })
            .collect();
        let (mut uniform, mut edge_light) = (vec![0.0; count], vec![0.0; count]);
        for (index, layer) in layers.iter().enumerate() {
            let passed = layer.cut(&transmissions[index]);
            let (covered, behind) = (&covered[index], &behind[index]);
            let light = (covered.iter().zip(behind).zip(&passed)).map(|((a, b), t)| t * (a + b));
            layer.add_to(&mut uniform, &light.collect::<Vec<_>>());
            let mixed =
                (covered.iter().zip(behind).zip(&passed)).map(|((a, b), t)| t * b + (1.0 - t) * a);
            layer.add_to(&mut edge_light, &mixed.collect::<Vec<_>>());
        }
        let gains: Vec<f32> = (uniform.iter())
            .map(|light| light.max(MIN_UNIFORM_LIGHT).recip())
            .collect();
        (layers.par_iter_mut().zip(&transmissions))
            .try_for_each(|(layer, passed)| layer.set_transmission(passed, &gains))?;
        let (width, surface) = (size.0, self.surface);
        let front = Links::new(count, width, |a, b| surface.is_front_joined(a, b));
        let back = Links::new(count, width, |a, b| surface.is_back_joined(a, b));
        Ok(Depth {
            gains,
            links: front.followed_by(back),
            surface,
            edge_light,
        })
    }
}

/// Returns the smallest window with all pixels whose coverage is above zero, if there are any.
pub(super) fn covered_window(coverage: &[f32], width: usize) -> Option<RenderWindow> {
    let (mut left, mut right, mut top, mut bottom) = (usize::MAX, 0, usize::MAX, 0);
    for (y, row) in coverage.chunks_exact(width).enumerate() {
        let Some(first) = row.iter().position(|share| *share > 0.0) else {
            continue;
        };
        let last = row.iter().rposition(|share| *share > 0.0).unwrap_or(first);
        (left, right) = (left.min(first), right.max(last + 1));
        (top, bottom) = (top.min(y), y + 1);
    }
    (left < right).then(|| RenderWindow {
        column: left,
        row: top,
        width: right - left,
        height: bottom - top,
    })
}
