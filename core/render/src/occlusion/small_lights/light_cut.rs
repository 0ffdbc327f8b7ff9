//! Lights as they are seen past nearer surfaces: drawn with their own kernels, and cut.

use super::super::depth_layers::DepthLayers;
use super::super::layer_samples::share;
use super::light_disc::LightDisc;
use super::shared_kernels::SharedKernels;
use super::signed_blur::SignedBlur;
use super::surface_blocks::SurfaceBlocks;
use super::{
    CellLights, LARGEST_CELL_PX, LEAST_DISTANCE, LEAST_RADIUS_PX, NearbyRange, Surfaces, middle,
};
use crate::scatter::kernel_reach;
use crate::{LocalKernel, Plane, RenderWindow, Scene};
use seidel_optics::error::Result;
use std::sync::Arc;

/// Points of the aperture through which a light that is dimmed evenly is seen.
const APERTURE_POINTS: usize = 64;

/// A cell of lights with the kernels that blur them.
#[derive(Clone)]
pub(super) struct DrawnCell<'a> {
    pub(super) cell: &'a CellLights,
    pub(super) vergence: f64,
    /// One a plane; `None` in planes without light.
    kernels: Vec<Option<Arc<LocalKernel>>>,
}

/// The surfaces that cut discs of lights.
pub(in super::super) struct LightCut<'a> {
    pub(in super::super) scene: &'a Scene<'a>,
    /// The part of the plate to render.
    pub(in super::super) window: RenderWindow,
    pub(in super::super) layers: &'a DepthLayers,
    pub(in super::super) blur: &'a SignedBlur,
    /// Layer coordinate of every pixel.
    pub(in super::super) coordinates: &'a [f32],
    /// The planes that hold light, for their channel weights.
    pub(in super::super) planes: &'a [Plane<'a>],
}

impl LightCut<'_> {
    /// Returns whether light of a cell may get to the window.
    fn is_seen(&self, cell: &CellLights) -> bool {
        if self.window == RenderWindow::whole(self.scene) {
            return true;
        }
        let (low, high) = self.layers.around(cell.coordinate);
        let (column, row) = cell.pixels[0];
        let near = RenderWindow {
            column,
            row,
            width: 1,
            height: 1,
        };
        [low, high].into_iter().any(|layer| {
            let reach = kernel_reach(self.scene, near, self.layers.vergence(layer));
            let is_near = |at: usize, first: usize, length: usize, before: f64, after: f64| {
                let reach = before.max(after) + LARGEST_CELL_PX as f64;
                let at = at as f64;
                at + reach >= first as f64 && at - reach <= (first + length) as f64
            };
            let RenderWindow { width, height, .. } = self.window;
            is_near(
                column,
                self.window.column,
                width,
                reach.left_px,
                reach.right_px,
            ) && is_near(row, self.window.row, height, reach.up_px, reach.down_px)
        })
    }

    /// Draws the kernels of all cells of a block; of none if no light of it gets to the window. Cells share kernels, so those of a part
    /// of a block would differ from those of the whole.
    ///
    /// # Errors
    /// A lens that cannot be drawn there.
    pub(super) fn drawn_cells<'c>(&'c self, cells: &'c [CellLights]) -> Result<Vec<DrawnCell<'c>>> {
        if !cells.iter().any(|cell| self.is_seen(cell)) {
            return Ok(Vec::new());
        }
        let mut kernels = SharedKernels::new(self.scene);
        let drawn = cells.iter().map(|cell| {
            let vergence = self.vergence(cell.coordinate);
            let of_plane = |(index, plane): (usize, &Plane<'c>)| {
                let mut lights = cell.excess.iter().skip(index).step_by(self.planes.len());
                let is_lit = lights.any(|light| *light != 0.0);
                let kernel = || kernels.at(cell.middle(), vergence, plane.weights);
                is_lit.then(kernel).transpose()
            };
            let planes = self.planes.iter().enumerate();
            Ok(DrawnCell {
                cell,
                vergence,
                kernels: planes.map(of_plane).collect::<Result<_>>()?,
            })
        });
        drawn.collect()
    }

    /// Returns the vergence at a layer coordinate, 1/m.
    fn vergence(&self, coordinate: f32) -> f64 {
        let (low, high) = self.layers.around(coordinate);
        let share = f64::from(coordinate - self.layers.coordinate_of(low));
        self.layers.vergence(low) * (1.0 - share) + self.layers.vergence(high) * share
    }

    /// Returns the discs of a cell as far as they are seen: one for each group of its lights and each plane.
    pub(super) fn discs(&self, drawn: &DrawnCell, surfaces: &Surfaces) -> Vec<LightDisc> {
        let DrawnCell { cell, kernels, .. } = drawn;
        let mut discs = Vec::new();
        for group in cell.groups(
            self.blur.radius_px(cell.coordinate).abs(),
            self.planes.len(),
        ) {
            let first = discs.len();
            for (index, kernel) in kernels.iter().enumerate() {
                let lit = group.iter().map(|(pixel, light)| (*pixel, light[index]));
                let lit: Vec<_> = lit.filter(|(_, light)| *light != 0.0).collect();
                if let Some(kernel) = kernel.as_ref().filter(|_| !lit.is_empty()) {
                    discs.push(LightDisc::new(index, &lit, kernel));
                }
            }
            if cell.is_cut {
                let pixels = group.iter().map(|(pixel, _)| *pixel);
                let at = middle(pixels);
                self.cut(surfaces, cell.coordinate, at, &mut discs[first..]);
            }
        }
        discs
    }

    /// Multiplies the discs of a light at a point and a layer coordinate by the share that nearer surfaces let pass.
    fn cut(&self, surfaces: &Surfaces, coordinate: f32, at: (f64, f64), discs: &mut [LightDisc]) {
        let (x, y) = at;
        let reach = discs.iter().map(|disc| disc.reach_px(at));
        let reach = reach.fold(0.0, f64::max);
        let own_radius = self.blur.radius_px(coordinate);
        if own_radius.abs() < LEAST_RADIUS_PX {
            let passing = self.evenly_passing(surfaces, coordinate, at);
            for disc in discs {
                disc.dim(passing);
            }
            return;
        }
        let ratio = |at: f32| 1.0 - self.blur.radius_px(at) / own_radius;
        let nearer = self.nearer_layers(coordinate);
        let widest = nearer.iter().map(|at| ratio(*at).abs());
        let reach = widest.fold(1.0, f64::max) * reach;
        let nearer = surfaces.blocks.layers_within(at, reach, &nearer);
        let nearer: Vec<(f32, f64)> = nearer.map(|at| (at, ratio(at))).collect();
        // The discs of all planes nearly cover each other.
        let bounds = |of: fn(&LightDisc) -> (i32, i32)| {
            let ends = discs.iter().map(of);
            ends.fold((i32::MAX, i32::MIN), |(low, high), (first, end)| {
                (low.min(first), high.max(end))
            })
        };
        // Light beyond the window is lost.
        let seen = |(first, end): (i32, i32), from: usize, count: usize| {
            (first.max(from as i32), end.min((from + count) as i32))
        };
        let window = self.window;
        let columns = seen(bounds(LightDisc::columns), window.column, window.width);
        let rows = seen(bounds(LightDisc::rows), window.row, window.height);
        if columns.0 >= columns.1 {
            return;
        }
        let mut lit: Vec<usize> = Vec::new();
        let mut hidden = vec![0.0_f32; (columns.1 - columns.0) as usize];
        for row in rows.0..rows.1 {
            lit.clear();
            let all = (0..).zip(columns.0..columns.1);
            lit.extend(
                all.filter(|(_, column)| discs.iter().any(|disc| disc.is_lit(*column, row)))
                    .map(|(index, _)| index),
            );
            let (Some(first), Some(last)) = (lit.first(), lit.last()) else {
                continue;
            };
            hidden.fill(0.0);
            let dy = f64::from(row) + 0.5 - y;
            let dx = |index: usize| f64::from(columns.0 + index as i32) + 0.5 - x;
            for (layer, ratio) in &nearer {
                let column = |index: usize| x + ratio * dx(index);
                let line = self.surface_row(y + ratio * dy, *layer);
                if line.may_hold(surfaces.blocks, [column(*first), column(*last)]) {
                    for index in &lit {
                        hidden[*index] += line.presence(&surfaces.nearby, column(*index));
                    }
                }
            }
            for disc in &mut *discs {
                let (left, line) = (disc.left, disc.line_mut(row));
                let seen = line.and_then(|line| line.get_mut((columns.0 - left).max(0) as usize..));
                let hidden = hidden.get((left - columns.0).max(0) as usize..);
                if let (Some(seen), Some(hidden)) = (seen, hidden) {
                    for (sample, hidden) in seen.iter_mut().zip(hidden) {
                        *sample *= (1.0 - hidden).max(0.0);
                    }
                }
            }
        }
    }

    /// Returns the share of the aperture through which a light nearly in focus, at a point and a layer coordinate, is seen past nearer
    /// surfaces. The ray through a point a of the unit disc passes a surface at P - a (r(surface) - r(light)).
    fn evenly_passing(&self, surfaces: &Surfaces, coordinate: f32, at: (f64, f64)) -> f32 {
        let own_radius = self.blur.radius_px(coordinate);
        let radius = |at: f32| self.blur.radius_px(at) - own_radius;
        let nearer = self.nearer_layers(coordinate);
        let reach = nearer.iter().map(|at| radius(*at).abs());
        let reach = reach.fold(1.0, f64::max);
        let nearer = surfaces.blocks.layers_within(at, reach, &nearer);
        let nearer: Vec<(f32, f64)> = nearer.map(|at| (at, radius(at))).collect();
        let passing = |point: usize| {
            let [x, y] = sunflower_point(point, APERTURE_POINTS);
            let hidden = nearer.iter().map(|(layer, radius)| {
                let q = (at.0 - radius * x, at.1 - radius * y);
                self.surface_row(q.1, *layer)
                    .presence(&surfaces.nearby, q.0)
            });
            (1.0 - hidden.sum::<f32>()).max(0.0)
        };
        (0..APERTURE_POINTS).map(passing).sum::<f32>() / APERTURE_POINTS as f32
    }

    /// Returns the layers that cut a light at a layer coordinate.
    fn nearer_layers(&self, coordinate: f32) -> Vec<f32> {
        (0..self.layers.len())
            .map(|layer| self.layers.coordinate_of(layer))
            .filter(|at| *at >= coordinate + LEAST_DISTANCE)
            .collect()
    }

    /// Returns the plate's surface in the layer at coordinate `layer`, along a line of constant `y`.
    fn surface_row(&self, y: f64, layer: f32) -> SurfaceRow<'_> {
        let Scene { width, height, .. } = *self.scene;
        let row = pixel_holding(y);
        let line = |row: i64| row.clamp(0, height as i64 - 1) as usize * width;
        SurfaceRow {
            layer,
            row,
            first: line(row),
            lines: [-1, 0, 1].map(|dy| &self.coordinates[line(row + dy)..][..width]),
            weights: spline_weights(y, row),
        }
    }
}

/// The surface of a plate in one layer, along a line of constant y. Pixels are interpolated with quadratic B-splines, so that the
/// stairs of a depth pass do not show.
struct SurfaceRow<'a> {
    /// Coordinate of the layer.
    layer: f32,
    /// The row of pixels that holds the line; may be outside the plate.
    row: i64,
    /// Index of the first pixel of that row, or of the nearest one on the plate.
    first: usize,
    /// Layer coordinates of the pixels of the three rows about the line, and the weights of the rows.
    lines: [&'a [f32]; 3],
    weights: [f32; 3],
}

impl SurfaceRow<'_> {
    /// Returns whether the layer may hold a pixel that presence at the positions from one of the `ends` to the other depends on.
    fn may_hold(&self, blocks: &SurfaceBlocks, ends: [f64; 2]) -> bool {
        let [left, right] = [ends[0].min(ends[1]), ends[0].max(ends[1])].map(pixel_holding);
        blocks.may_hold(
            [left - 1, right + 1],
            [self.row - 1, self.row + 1],
            self.layer,
        )
    }

    /// Returns the presence of the surface at position `x`.
    fn presence(&self, nearby: &NearbyRange, x: f64) -> f32 {
        let width = self.lines[0].len();
        let column = pixel_holding(x);
        let inside = |column: i64| column.clamp(0, width as i64 - 1) as usize;
        if !nearby.may_hold(self.first + inside(column), self.layer) {
            return 0.0;
        }
        let mut sum = 0.0;
        for (line, wy) in self.lines.iter().zip(self.weights) {
            for (dx, wx) in (-1..).zip(spline_weights(x, column)) {
                sum += wx * wy * share(line[inside(column + dx)], self.layer);
            }
        }
        sum
    }
}

/// Returns point `index` of `count` evenly spread over the unit disc: Vogel's spiral.
fn sunflower_point(index: usize, count: usize) -> [f64; 2] {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let radius = ((index as f64 + 0.5) / count as f64).sqrt();
    let (sin, cos) = (golden_angle * index as f64).sin_cos();
    [radius * cos, radius * sin]
}

/// Returns the pixel that holds a position, px from the outer corner.
fn pixel_holding(at: f64) -> i64 {
    // Faster than `floor`, which is a call of a function on processors without SSE4.1.
    let towards_zero = at as i64;
    towards_zero - i64::from(towards_zero as f64 > at)
}

/// Returns the weights of the pixel before the one that holds the position `at`, of it and of the one after it.
fn spline_weights(at: f64, pixel: i64) -> [f32; 3] {
    let t = (at - pixel as f64 - 0.5) as f32;
    let side = |t: f32| 0.5 * (0.5 + t) * (0.5 + t);
    [side(-t), 0.75 - t * t, side(t)]
}
