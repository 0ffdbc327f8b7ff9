//! Small bright lights behind blurred edges: their discs are cut where the edge hides a part of the aperture.
//!
//! The compositor dims a layer by the share of the aperture that nearer surfaces hide, the same for all of its light.
//! That is right for even surfaces. A point light at P is seen at pixel x through one point of the aperture alone, which
//! is hidden or is not. With r the signed radius of the blur, the ray through that point passes a nearer surface at the
//! image position
//!
//!   q = P + (x - P) (1 - r(surface) / r(light)).
//!
//! The light is hidden where the plate shows that surface at q. What the plate itself hides behind its own pixels is
//! not known: a surface behind another one cannot cut a light.

mod light_disc;
mod nearby_range;
mod signed_blur;
mod surface_blocks;

pub(super) use signed_blur::SignedBlur;

use super::depth_layers::DepthLayers;
use super::disocclusion::LayeredPlate;
use super::layer_samples::{cropped_scene, share};
use crate::gather::find_highlights;
use crate::scatter::kernel_reach;
use crate::{LocalKernel, LocalKernels, Plane, RenderWindow, Scene, cancelled};
use light_disc::LightDisc;
use nearby_range::NearbyRange;
use rayon::prelude::*;
use seidel_optics::error::Result;
use std::borrow::Cow;
use std::collections::BTreeMap;
use surface_blocks::{NearerSurfaces, SurfaceBlocks};

/// Most highlights of a block of 32 x 32 px in each plane.
const MAX_HIGHLIGHTS: usize = 256;

/// Least distance between a light and a surface that cuts its disc, layers. Within it they may be one slanted surface.
const LEAST_DISTANCE: f32 = 2.0;

/// Least radius of a disc that is cut, px. A smaller one is dimmed evenly, as a light in focus is.
const LEAST_RADIUS_PX: f64 = 1.5;

/// Side of the cells whose lights share a kernel, px.
const CELL_PX: usize = 4;

/// Radius of a disc over the side of the groups of its lights that are cut together.
const RADIUS_OF_GROUP: f64 = 8.0;

/// Reach of a kernel over its size, the radius of an even disc: room for displacement and for shapes with tails.
const KERNEL_REACH: f64 = 1.5;

/// The lights of one cell at nearly one depth.
#[derive(Default)]
struct CellLights {
    /// Mean layer coordinate.
    coordinate: f32,
    /// Column and row of each light.
    pixels: Vec<(usize, usize)>,
    /// Light of each in every plane, pixel by pixel.
    excess: Vec<f32>,
}

/// Lights whose discs are cut, taken out of their plate.
pub(super) struct CutLights<'a> {
    /// The planes without these lights.
    rest: Vec<Cow<'a, [f32]>>,
    cells: Vec<CellLights>,
    surfaces: Surfaces,
}

/// The surfaces of a plate, by blocks and by pixels; none where no lights are cut.
#[derive(Default)]
struct Surfaces {
    blocks: SurfaceBlocks,
    nearby: NearbyRange,
}

impl<'a> CutLights<'a> {
    /// Finds the lights of a plate that nearer surfaces cut: highlights with such a surface within their disc.
    pub(super) fn find(input: &LayeredPlate<'a>, layers: &DepthLayers, blur: &SignedBlur) -> Self {
        let count = input.planes.len();
        let mut rest: Vec<Cow<[f32]>> = input
            .planes
            .iter()
            .map(|plane| Cow::Borrowed(plane.samples))
            .collect();
        let mut cells: BTreeMap<(usize, usize, i32), CellLights> = BTreeMap::new();
        let highlights = find_highlights(input.planes, input.width, MAX_HIGHLIGHTS);
        if highlights.is_empty() {
            return Self {
                rest,
                cells: Vec::new(),
                surfaces: Surfaces::default(),
            };
        }
        let blocks = SurfaceBlocks::new(input);
        for block in highlights {
            for (&(row, column), excess) in block.pixels.iter().zip(block.excess.chunks(count)) {
                let index = row * input.width + column;
                let coordinate = input.coordinates[index];
                let cell = (row / CELL_PX, column / CELL_PX, coordinate.round() as i32);
                let lights = cells.entry(cell).or_default();
                lights.add((column, row), coordinate, excess);
            }
        }
        let is_cut = |lights: &CellLights| {
            let reach_px = KERNEL_REACH * f64::from(layers.size(lights.coordinate));
            let nearer = NearerSurfaces {
                from: lights.coordinate + LEAST_DISTANCE,
                blur,
                own_radius_px: blur.radius_px(lights.coordinate),
                reach_px,
            };
            nearer.own_radius_px.abs() >= LEAST_RADIUS_PX
                && blocks.any_within(lights.middle(), &nearer)
        };
        let cells: Vec<CellLights> = cells.into_values().filter(is_cut).collect();
        for lights in &cells {
            for (&(column, row), excess) in lights.pixels.iter().zip(lights.excess.chunks(count)) {
                for (plane, excess) in rest.iter_mut().zip(excess) {
                    if *excess != 0.0 {
                        plane.to_mut()[row * input.width + column] -= excess;
                    }
                }
            }
        }
        let nearby = if cells.is_empty() {
            NearbyRange::default()
        } else {
            NearbyRange::new(input)
        };
        Self {
            rest,
            cells,
            surfaces: Surfaces { blocks, nearby },
        }
    }

    /// The planes without these lights.
    pub(super) fn rest<'s>(&'s self, planes: &'s [Plane<'s>]) -> Vec<Plane<'s>> {
        let rest = self.rest.iter().zip(planes);
        rest.map(|(samples, plane)| Plane {
            samples,
            weights: plane.weights,
        })
        .collect()
    }

    /// Adds the blurred lights, each cut by the surfaces in front of it, to `out`, the planes of the window of `cut`. `transmittance`
    /// returns the share of light at a vergence and layer coordinate that passes sharp mattes at a pixel of the plate.
    ///
    /// # Errors
    /// A lens that cannot be drawn at a light, and a cancelled render.
    pub(super) fn add_to(
        &self,
        out: &mut [Vec<f32>],
        cut: &LightCut,
        transmittance: &(dyn Fn(f64, f32, usize) -> f32 + Sync),
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<()> {
        /// Cells drawn before they are added: bounds the memory taken.
        const WAVE: usize = 32;
        let seen: Vec<&CellLights> = self.cells.iter().filter(|cell| cut.is_seen(cell)).collect();
        for wave in seen.chunks(WAVE) {
            let discs: Vec<Vec<LightDisc>> = wave
                .par_iter()
                .map(|cell| cut.discs(cell, &self.surfaces))
                .collect::<Result<_>>()?;
            out.par_iter_mut().enumerate().for_each(|(plane, out)| {
                for (cell, discs) in wave.iter().zip(&discs) {
                    for disc in discs.iter().filter(|disc| disc.plane == plane) {
                        disc.add(out, cut.scene, cut.window, |index| {
                            transmittance(disc.vergence, cell.coordinate, index)
                        });
                    }
                }
            });
            if !progress(1.0) {
                return Err(cancelled());
            }
        }
        Ok(())
    }
}

impl CellLights {
    fn add(&mut self, pixel: (usize, usize), coordinate: f32, excess: &[f32]) {
        let before = self.pixels.len() as f32;
        self.coordinate = (before * self.coordinate + coordinate) / (before + 1.0);
        self.pixels.push(pixel);
        self.excess.extend(excess);
    }

    /// Returns the middle of the lights, px from the outer corner of the plate.
    fn middle(&self) -> (f64, f64) {
        middle(self.pixels.iter().copied())
    }

    /// Returns the lights, each with its light in all `planes`, in groups that are cut together: of a side that is small
    /// against the radius of their disc.
    fn groups(&self, radius_px: f64, planes: usize) -> Vec<Vec<PixelLight<'_>>> {
        let side = ((radius_px / RADIUS_OF_GROUP).round() as usize).clamp(1, CELL_PX);
        let mut groups: BTreeMap<(usize, usize), Vec<PixelLight>> = BTreeMap::new();
        for (&(column, row), light) in self.pixels.iter().zip(self.excess.chunks(planes)) {
            let group = groups.entry((row / side, column / side)).or_default();
            group.push(((column, row), light));
        }
        groups.into_values().collect()
    }
}

/// A pixel, column first, and its light in all planes.
type PixelLight<'a> = ((usize, usize), &'a [f32]);

/// Returns the middle of pixels, px from the outer corner of the plate.
fn middle(pixels: impl Iterator<Item = (usize, usize)>) -> (f64, f64) {
    let (mut count, mut x, mut y) = (0.0, 0.0, 0.0);
    for (column, row) in pixels {
        count += 1.0;
        x += column as f64 + 0.5;
        y += row as f64 + 0.5;
    }
    (x / count, y / count)
}

/// The surfaces that cut discs of lights.
pub(super) struct LightCut<'a> {
    pub(super) scene: &'a Scene<'a>,
    /// The part of the plate to render.
    pub(super) window: RenderWindow,
    pub(super) layers: &'a DepthLayers,
    pub(super) blur: &'a SignedBlur,
    /// Layer coordinate of every pixel.
    pub(super) coordinates: &'a [f32],
    /// Channel weights of each plane.
    pub(super) planes: &'a [Plane<'a>],
}

impl LightCut<'_> {
    /// Returns whether light of a cell may get to the window.
    fn is_seen(&self, cell: &CellLights) -> bool {
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
                let reach = before.max(after) + CELL_PX as f64;
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

    /// Returns the cut discs of a cell, one for each pixel and plane with light.
    ///
    /// # Errors
    /// A lens that cannot be drawn there.
    fn discs(&self, cell: &CellLights, surfaces: &Surfaces) -> Result<Vec<LightDisc>> {
        let (low, _) = self.layers.around(cell.coordinate);
        let share = f64::from(cell.coordinate - self.layers.coordinate_of(low));
        let (far, near) = (self.layers.vergence(low), self.layers.vergence(low + 1));
        let vergence = far * (1.0 - share) + near * share;
        let (x, y) = cell.middle();
        let pixel = RenderWindow {
            column: x as usize,
            row: y as usize,
            width: 1,
            height: 1,
        };
        let scene = cropped_scene(self.scene, pixel, vergence);
        let at = (x - pixel.column as f64, y - pixel.row as f64);
        let mut kernels: Vec<(&[f64], LocalKernel)> = Vec::new();
        for (index, plane) in self.planes.iter().enumerate() {
            let mut lights = cell.excess.iter().skip(index).step_by(self.planes.len());
            let is_known = kernels.iter().any(|(known, _)| *known == plane.weights);
            if !is_known && lights.any(|light| *light != 0.0) {
                let kernel = LocalKernels::new(&scene, plane.weights)?.at(at)?;
                kernels.push((plane.weights, kernel));
            }
        }
        let mut discs = Vec::new();
        for group in cell.groups(
            self.blur.radius_px(cell.coordinate).abs(),
            self.planes.len(),
        ) {
            let first = discs.len();
            for (index, plane) in self.planes.iter().enumerate() {
                let lit = group.iter().map(|(pixel, light)| (*pixel, light[index]));
                let lit: Vec<_> = lit.filter(|(_, light)| *light != 0.0).collect();
                let known = kernels.iter().find(|(known, _)| *known == plane.weights);
                if let Some((_, kernel)) = known.filter(|_| !lit.is_empty()) {
                    discs.push(LightDisc::new(index, vergence, &lit, kernel));
                }
            }
            let pixels = group.iter().map(|(pixel, _)| *pixel);
            self.cut(
                surfaces,
                cell.coordinate,
                middle(pixels),
                &mut discs[first..],
            );
        }
        Ok(discs)
    }

    /// Multiplies the discs of a light at a point and a layer coordinate by the share that nearer surfaces let pass.
    fn cut(&self, surfaces: &Surfaces, coordinate: f32, at: (f64, f64), discs: &mut [LightDisc]) {
        let (x, y) = at;
        let reach = discs.iter().map(|disc| disc.reach_px(at));
        let reach = reach.fold(0.0, f64::max);
        let own_radius = self.blur.radius_px(coordinate);
        let ratio = |at: f32| 1.0 - self.blur.radius_px(at) / own_radius;
        let all: Vec<f32> = (0..self.layers.len())
            .map(|layer| self.layers.coordinate_of(layer))
            .filter(|at| *at >= coordinate + LEAST_DISTANCE)
            .collect();
        let widest = all.iter().map(|at| ratio(*at).abs()).fold(1.0, f64::max);
        let present = surfaces.blocks.layers_within(at, widest * reach, &all);
        let present = all.iter().zip(present).filter(|(_, present)| *present);
        let nearer: Vec<(f32, f64)> = present.map(|(at, _)| (*at, ratio(*at))).collect();
        let passing = |column: i32, row: i32| {
            let (dx, dy) = (f64::from(column) + 0.5 - x, f64::from(row) + 0.5 - y);
            let hidden = nearer.iter().map(|(at, ratio)| {
                self.presence(&surfaces.nearby, (x + ratio * dx, y + ratio * dy), *at)
            });
            (1.0 - hidden.sum::<f32>()).max(0.0)
        };
        // The discs of all planes nearly cover each other.
        let bounds = |of: fn(&LightDisc) -> (i32, i32)| {
            let ends = discs.iter().map(of);
            ends.fold((i32::MAX, i32::MIN), |(low, high), (first, end)| {
                (low.min(first), high.max(end))
            })
        };
        let columns = bounds(LightDisc::columns);
        let rows = bounds(LightDisc::rows);
        for row in rows.0..rows.1 {
            let known: Vec<f32> = (columns.0..columns.1)
                .map(|column| {
                    let is_lit = discs.iter().any(|disc| disc.is_lit(column, row));
                    if is_lit { passing(column, row) } else { 0.0 }
                })
                .collect();
            for disc in &mut *discs {
                let offset = (disc.left - columns.0) as usize;
                if let Some(line) = disc.line_mut(row) {
                    for (sample, passing) in line.iter_mut().zip(&known[offset..]) {
                        *sample *= passing;
                    }
                }
            }
        }
    }

    /// Returns the presence of the plate's surface in the layer at coordinate `layer`, at a point. Pixels are interpolated with
    /// quadratic B-splines, so that the stairs of a depth pass do not show.
    fn presence(&self, nearby: &NearbyRange, at: (f64, f64), layer: f32) -> f32 {
        let (x, y) = at;
        let Scene { width, height, .. } = *self.scene;
        let (column, row) = (pixel_holding(x), pixel_holding(y));
        let inside = |at: i64, size: usize| at.clamp(0, size as i64 - 1) as usize;
        if !nearby.may_hold(inside(row, height) * width + inside(column, width), layer) {
            return 0.0;
        }
        let (columns, rows) = (spline_weights(x, column), spline_weights(y, row));
        let mut sum = 0.0;
        for (dy, wy) in (-1..).zip(rows) {
            let line = inside(row + dy, height) * width;
            for (dx, wx) in (-1..).zip(columns) {
                let own = self.coordinates[line + inside(column + dx, width)];
                sum += wx * wy * share(own, layer);
            }
        }
        sum
    }
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
