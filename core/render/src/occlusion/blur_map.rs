//! The circle of confusion and the depth slice of every pixel: the blur of a plate as numbers, without rendering it.

use rayon::prelude::*;

use super::depth_edges;
use super::depth_layers::{DepthLayers, LayerSpacing};
use crate::depth::FocusPlane;
use crate::{Scene, VergencePass};

/// Fields at which the lens is probed along each side of the plate. Blur varies slowly over the field.
const FIELDS: usize = 17;

/// The side of the plane of focus on which a pixel lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FocusSide {
    /// Nearer than the plane of focus.
    Front,
    /// Farther.
    Behind,
}

/// The circle of confusion and the depth slice of every pixel of a plate.
#[derive(Debug, Clone)]
pub struct BlurMap {
    /// Diameter of the circle of confusion of every pixel, plate px: that of the even disc with the variance of the blur.
    pub diameter_px: Vec<f32>,
    /// The same for an object in the plane of focus at that pixel; that of the pixel where the lens has no focus.
    pub focused_px: Vec<f32>,
    /// Whether every pixel is nearer than the plane of focus.
    is_front: Vec<bool>,
    /// Vergence at which the lens is sharpest on its axis, 1/m.
    pub focus_per_m: Option<f64>,
    /// The depth slices that the plate is rendered in, from the farthest; empty where depth is constant.
    pub slices: Vec<DepthSlice>,
    /// Index into [`Self::slices`] of every pixel; empty where depth is constant.
    pub slice_of: Vec<u16>,
}

/// A depth slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthSlice {
    /// Vergence of the slice, 1/m.
    pub vergence_per_m: f64,
    /// Largest diameter of a circle of confusion in the frame at this vergence, plate px.
    pub diameter_px: f64,
    /// Pixels in it.
    pub pixels: usize,
}

impl BlurMap {
    /// Computes the map of `scene`; `weights` are those of the lens's channels.
    #[must_use]
    pub fn new(scene: &Scene, weights: &[f64]) -> Self {
        let (lowest, highest) = vergence_range(scene);
        let plane = FocusPlane::new(scene.lens);
        let width = scene.width.max(1);
        let frame = scene.lens.frame();
        let field = |index: usize| {
            let at = scene.map.frame_point(index % width, index / width);
            frame.field_point(at)
        };
        // Vergence is linear over the frame: largest and least at its corners.
        let last = scene.pixel_count().saturating_sub(1);
        let corners = [0, width - 1, last + 1 - width.min(last + 1), last].map(field);
        let in_focus = || {
            plane
                .iter()
                .flat_map(|plane| corners.map(|at| plane.vergence_at(at)))
        };
        let (lowest, highest) = (
            in_focus().fold(lowest, f64::min),
            in_focus().fold(highest, f64::max),
        );
        let layers = DepthLayers::new(scene, lowest, highest, LayerSpacing::BY_BLUR);
        let table = DiameterTable::new(scene, weights, &layers);
        let rows = |of: &(dyn Fn(usize) -> f32 + Sync)| -> Vec<f32> {
            let all = 0..scene.pixel_count();
            all.into_par_iter()
                .map(|index| table.at(index % width, index / width, of(index)))
                .collect()
        };
        let coordinate = |index| layers.coordinate(scene.vergence_at(index));
        let diameter_px = rows(&coordinate);
        let focused_px = match &plane {
            Some(plane) => rows(&|index| layers.coordinate(plane.vergence_at(field(index)))),
            None => diameter_px.clone(),
        };
        let is_front = (0..scene.pixel_count()).into_par_iter().map(|index| {
            let focus = plane.as_ref().map(|plane| plane.vergence_at(field(index)));
            focus.is_some_and(|focus| scene.vergence_at(index) > focus)
        });
        let (slices, slice_of) = slices(scene, &layers);
        Self {
            diameter_px,
            focused_px,
            is_front: is_front.collect(),
            focus_per_m: plane.map(|plane| plane.on_axis_per_m),
            slices,
            slice_of,
        }
    }

    /// Returns the diameter of the circle of confusion of the pixel at `index`, plate px, negative in front of the focus.
    #[must_use]
    pub fn signed_diameter_px(&self, index: usize) -> f32 {
        let diameter = self.diameter_px[index];
        match self.side(index) {
            Some(FocusSide::Front) => -diameter,
            _ => diameter,
        }
    }

    /// Returns the side of focus of the pixel at `index`; `None` where the lens has no focus.
    #[must_use]
    pub fn side(&self, index: usize) -> Option<FocusSide> {
        self.focus_per_m.map(|_| {
            if self.is_front[index] {
                FocusSide::Front
            } else {
                FocusSide::Behind
            }
        })
    }
}

fn vergence_range(scene: &Scene) -> (f64, f64) {
    match scene.vergence {
        VergencePass::Constant(vergence) => (vergence, vergence),
        VergencePass::PerPixel(pass) => {
            let least = pass.iter().copied().fold(f32::INFINITY, f32::min);
            let largest = pass.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            (f64::from(least), f64::from(largest))
        }
    }
}

/// Returns the slices of `scene` with their pixels, and the slice of every pixel, as the renderer cuts them.
fn slices(scene: &Scene, layers: &DepthLayers) -> (Vec<DepthSlice>, Vec<u16>) {
    let VergencePass::PerPixel(pass) = scene.vergence else {
        return (Vec::new(), Vec::new());
    };
    let coordinates: Vec<f32> = pass
        .par_iter()
        .map(|v| layers.coordinate(f64::from(*v)))
        .collect();
    let coordinates = depth_edges::snapped(&coordinates, scene.width, scene.height);
    let mut slices: Vec<DepthSlice> = (0..layers.len())
        .map(|index| DepthSlice {
            vergence_per_m: layers.vergence(index),
            // Sizes are radii.
            diameter_px: 2.0 * f64::from(layers.size(layers.coordinate_of(index))),
            pixels: 0,
        })
        .collect();
    let first = layers.coordinate_of(0);
    let slice_of: Vec<u16> = (coordinates.par_iter())
        .map(|coordinate| (coordinate - first).round() as u16)
        .collect();
    for slice in &slice_of {
        slices[usize::from(*slice)].pixels += 1;
    }
    (slices, slice_of)
}

/// Diameters of circles of confusion over the plate, by layer, interpolated between.
struct DiameterTable<'a> {
    layers: &'a DepthLayers,
    /// Pixels between two probes along x and y.
    step: [f64; 2],
    /// By layer, then row, then column, plate px.
    diameters: Vec<f32>,
}

impl<'a> DiameterTable<'a> {
    fn new(scene: &Scene, weights: &[f64], layers: &'a DepthLayers) -> Self {
        let step = [scene.width, scene.height]
            .map(|size| size.saturating_sub(1).max(1) as f64 / (FIELDS - 1) as f64);
        let frame = scene.lens.frame();
        let of_probe = |index: usize| {
            let (layer, place) = (index / (FIELDS * FIELDS), index % (FIELDS * FIELDS));
            let along = |k: usize, step: f64| (k as f64 * step).round() as usize;
            let column = along(place % FIELDS, step[0]);
            let row = along(place / FIELDS, step[1]);
            let field = frame.field_point(scene.map.frame_point(column, row));
            let vergence = layers.vergence(layer);
            let channels = weights.iter().enumerate().filter(|(_, w)| **w != 0.0);
            let variance = channels.map(|(channel, weight)| {
                let moments = scene.lens.blur_at(channel, field, vergence).blur.moments;
                0.5 * weight * (moments.mu20 + moments.mu02)
            });
            // The variance of an even disc is the square of a quarter of its diameter.
            (4.0 * variance.sum::<f64>().max(0.0).sqrt() * scene.map.scale) as f32
        };
        let count = layers.len() * FIELDS * FIELDS;
        Self {
            layers,
            step,
            diameters: (0..count).into_par_iter().map(of_probe).collect(),
        }
    }

    /// Returns the diameter at a pixel and a layer coordinate.
    fn at(&self, column: usize, row: usize, coordinate: f32) -> f32 {
        let (low, high) = self.layers.around(coordinate);
        let share = (coordinate - self.layers.coordinate_of(low)).clamp(0.0, 1.0);
        let place = |at: usize, step: f64| {
            let at = at as f64 / step;
            let low = (at as usize).min(FIELDS - 2);
            (low, (at - low as f64) as f32)
        };
        let (x, along_x) = place(column, self.step[0]);
        let (y, along_y) = place(row, self.step[1]);
        let in_layer = |layer: usize| {
            let value =
                |dx: usize, dy: usize| self.diameters[(layer * FIELDS + y + dy) * FIELDS + x + dx];
            let in_row = |dy: usize| value(0, dy) + along_x * (value(1, dy) - value(0, dy));
            in_row(0) + along_y * (in_row(1) - in_row(0))
        };
        in_layer(low) + share * (in_layer(high) - in_layer(low))
    }
}
