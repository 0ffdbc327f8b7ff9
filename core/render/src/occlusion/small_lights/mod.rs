//! Small bright lights, each blurred at its own depth, their discs cut where blurred edges hide a part of the aperture.
//!
//! A sample between two depth layers is blurred as a mixture of both, which even surfaces do not show. The disc of a small light
//! would get two rims. So small lights are taken out of the plate, and their discs are added to the composite of the rest.
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

mod light_cut;
mod light_disc;
mod nearby_range;
mod shared_kernels;
mod signed_blur;
mod surface_blocks;

pub(super) use light_cut::LightCut;
pub(super) use signed_blur::SignedBlur;

use super::depth_layers::DepthLayers;
use super::layered_plate::LayeredPlate;
use super::mixed_pixels::MixedPixels;
use crate::gather::{HighlightBlock, SearchArea, find_highlights};
use crate::mirroring::SMALL_LIGHTS;
use crate::{Plane, RenderWindow, cancelled};
use light_cut::DrawnCell;
use light_disc::LightDisc;
use nearby_range::NearbyRange;
use rayon::prelude::*;
use seidel_optics::error::Result;
use std::borrow::Cow;
use std::collections::BTreeMap;
use surface_blocks::{NearerSurfaces, SurfaceBlocks};

/// Least distance between a light and a surface that cuts its disc, layers. Within it they may be one slanted surface.
const LEAST_DISTANCE: f32 = 2.0;

/// Least radius of a disc that is cut, px. A smaller one is dimmed evenly.
const LEAST_RADIUS_PX: f64 = 1.5;

/// Steps from a pixel at the rim of a light to one that it covers whole.
const STEPS_TO_BRIGHTEST: usize = 3;

/// Side of the blocks in which lights are searched, on a grid fixed to the frame, px.
const BLOCK_PX: usize = 32;

/// The cells whose lights share a kernel.
#[derive(Clone, Copy)]
pub(super) struct LightCells {
    /// Side, px.
    side_px: usize,
    /// Cells a layer along the depth.
    per_layer: f32,
}

impl LightCells {
    pub(super) const FINE: Self = Self {
        side_px: 4,
        per_layer: 2.0,
    };
    /// For a preview: the truths of docs/background/depth-edges.md come out the same to 0.01 dB.
    pub(super) const COARSE: Self = Self {
        side_px: LARGEST_CELL_PX,
        per_layer: 1.0,
    };
}

/// Side of the largest cells, px.
const LARGEST_CELL_PX: usize = 8;

/// Radius of a disc over the side of the groups of its lights that are cut together.
const RADIUS_OF_GROUP: f64 = 8.0;

/// Reach of a kernel over its size, the radius of an even disc: room for displacement and for shapes with tails.
const KERNEL_REACH: f64 = 1.5;

/// The lights of one cell at nearly one depth.
#[derive(Default)]
struct CellLights {
    /// Side of the cell, px, and the position of the plate's first pixel in its own.
    side_px: usize,
    before: [usize; 2],
    /// Whether nearer surfaces may cut their discs.
    is_cut: bool,
    /// Mean layer coordinate.
    coordinate: f32,
    /// Column and row of each light.
    pixels: Vec<(usize, usize)>,
    /// Light of each in every plane that holds light, pixel by pixel.
    excess: Vec<f32>,
}

/// The small lights of a plate, taken out of it.
pub(super) struct SmallLights<'a> {
    /// The planes without these lights.
    rest: Vec<Cow<'a, [f32]>>,
    /// The cells of each block of 32 x 32 px.
    blocks: Vec<Vec<CellLights>>,
    surface_blocks: SurfaceBlocks,
}

/// The surfaces of a plate, by blocks and by pixels.
struct Surfaces<'a> {
    blocks: &'a SurfaceBlocks,
    /// Empty where no discs are cut.
    nearby: NearbyRange,
}

impl<'a> SmallLights<'a> {
    /// Finds the highlights of a plate, other than those whose blur is wider than the frame: they do not stand out once they are blurred,
    /// and a kernel each would take more work than the frame.
    pub(super) fn find(
        input: &LayeredPlate<'a>,
        mixed: &MixedPixels,
        layers: &DepthLayers,
        blur: &SignedBlur,
        light_cells: LightCells,
    ) -> Self {
        let count = input.light_count;
        let mut rest: Vec<Cow<[f32]>> = input
            .planes
            .iter()
            .map(|plane| Cow::Borrowed(plane.samples))
            .collect();
        let covered = covered_pixels(input);
        let area = SearchArea {
            width: input.width,
            before: input.origin.map(|at| at % BLOCK_PX),
            covered: covered.as_deref(),
        };
        let highlights = find_highlights(&input.planes[..count], &area, &SMALL_LIGHTS);
        if highlights.is_empty() {
            return Self {
                rest,
                blocks: Vec::new(),
                surface_blocks: SurfaceBlocks::default(),
            };
        }
        let least_light = least_light(&input.planes[..count], area.covered);
        let surface_blocks = SurfaceBlocks::new(input);
        let is_cut = |lights: &CellLights| {
            let own_radius = blur.radius_px(lights.coordinate);
            let kernel_reach = KERNEL_REACH * f64::from(layers.size(lights.coordinate));
            let reach_px = |at: f32| {
                let apart = (blur.radius_px(at) - own_radius).abs();
                if own_radius.abs() < LEAST_RADIUS_PX {
                    KERNEL_REACH * apart
                } else {
                    kernel_reach * apart / own_radius.abs()
                }
            };
            let nearer = NearerSurfaces {
                from: lights.coordinate + LEAST_DISTANCE,
                reach_px: &reach_px,
            };
            surface_blocks.any_within(lights.middle(), &nearer)
        };
        let of_block = |block: &HighlightBlock| -> Vec<CellLights> {
            let mut cells = cells(block, &least_light, input, mixed, light_cells);
            cells.retain(|lights| layers.size(lights.coordinate) < 2.0 * blur.frame_side_px);
            for lights in &mut cells {
                lights.is_cut = is_cut(lights);
            }
            cells
        };
        let blocks: Vec<_> = highlights.par_iter().map(of_block).collect();
        rest.par_iter_mut()
            .take(count)
            .enumerate()
            .for_each(|(plane, rest)| {
                for lights in blocks.iter().flatten() {
                    let excess = lights.excess.chunks(count).map(|excess| excess[plane]);
                    for (&(column, row), excess) in lights.pixels.iter().zip(excess) {
                        if excess != 0.0 {
                            let left = &mut rest.to_mut()[row * input.width + column];
                            *left = (*left - excess).max(left.min(0.0));
                        }
                    }
                }
            });
        Self {
            rest,
            blocks,
            surface_blocks,
        }
    }

    /// Returns the number of pixels that hold them.
    pub(super) fn pixel_count(&self) -> usize {
        let cells = self.blocks.iter().flatten();
        cells.map(|lights| lights.pixels.len()).sum()
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

    /// Adds the blurred lights, cut by the surfaces in front of them, to `out`, the planes of the window of `cut`. `transmittance`
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
        /// Blocks whose kernels are kept at a time, and cells whose discs are: bounds of the memory taken.
        const BLOCKS: usize = 64;
        const CELLS: usize = 32;
        let is_any_cut = self.blocks.iter().flatten().any(|lights| lights.is_cut);
        let nearby = is_any_cut.then(|| NearbyRange::new(cut.coordinates, cut.scene.width));
        let surfaces = Surfaces {
            blocks: &self.surface_blocks,
            nearby: nearby.unwrap_or_default(),
        };
        for blocks in self.blocks.chunks(BLOCKS) {
            let drawn: Vec<Vec<DrawnCell>> = blocks
                .par_iter()
                .map(|cells| cut.drawn_cells(cells))
                .collect::<Result<_>>()?;
            for wave in drawn.concat().chunks(CELLS) {
                add_wave(wave, out, cut, &surfaces, transmittance);
                if !progress(1.0) {
                    return Err(cancelled());
                }
            }
        }
        Ok(())
    }
}

/// Adds the lights of some cells to `out` as [`SmallLights::add_to`] does.
fn add_wave(
    wave: &[DrawnCell],
    out: &mut [Vec<f32>],
    cut: &LightCut,
    surfaces: &Surfaces,
    transmittance: &(dyn Fn(f64, f32, usize) -> f32 + Sync),
) {
    let discs: Vec<Vec<LightDisc>> = wave
        .par_iter()
        .map(|drawn| cut.discs(drawn, surfaces))
        .collect();
    out.par_iter_mut().enumerate().for_each(|(plane, out)| {
        for (drawn, discs) in wave.iter().zip(&discs) {
            for disc in discs.iter().filter(|disc| disc.plane == plane) {
                disc.add(out, cut.scene, cut.window, |index| {
                    transmittance(drawn.vergence, drawn.cell.coordinate, index)
                });
            }
        }
    });
}

/// Returns which pixels of `input` are covered: the known ones or, if there are planes of coverage, the ones of which a plane is not zero. `None` if all are.
fn covered_pixels(input: &LayeredPlate) -> Option<Vec<bool>> {
    let (width, has_coverage) = (input.width, input.light_count < input.planes.len());
    if !has_coverage && input.known == RenderWindow::from_size(width, input.height) {
        return None;
    }
    let is_covered = |index: usize| {
        if has_coverage {
            input.planes.iter().any(|plane| plane.samples[index] != 0.0)
        } else {
            input.known.holds(index % width, index / width)
        }
    };
    let pixels = (0..input.coordinates.len()).into_par_iter();
    Some(pixels.map(is_covered).collect())
}

/// Returns for each plane the value that small lights exceed in blocks of which a part is unknown or uncovered: some times the mean of
/// covered pixels. A speck over nothing, like its neighbours but for size, is no light.
fn least_light(planes: &[Plane], covered: Option<&[bool]>) -> Vec<f32> {
    /// Parts of one size, added in order: the sum is the same whatever the number of threads.
    const PART: usize = 1 << 14;
    let mean = |plane: &Plane| {
        let parts = plane.samples.par_chunks(PART).enumerate();
        let sums: Vec<(f64, usize)> = parts
            .map(|(part, light)| {
                let is_covered = |k: usize| covered.is_none_or(|covered| covered[part * PART + k]);
                let covered = light.iter().enumerate().filter(|(k, _)| is_covered(*k));
                covered.fold((0.0, 0), |(sum, count), (_, light)| {
                    (sum + f64::from(light.abs()), count + 1)
                })
            })
            .collect();
        let (sum, count) = sums
            .iter()
            .fold((0.0, 0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
        (sum / count.max(1) as f64) as f32
    };
    let limit = |plane: &Plane| SMALL_LIGHTS.contrast * mean(plane);
    planes.iter().map(limit).collect()
}

/// Returns the highlights of a block, cell by cell; in a block that is partly unknown or uncovered those that exceed the `least_light` of
/// their planes.
///
/// A depth pass often gives the pixels at the rim of a light the depth of the surface behind it. All light that stands out has the
/// depth of the brightest pixel close by.
fn cells(
    block: &HighlightBlock,
    least_light: &[f32],
    input: &LayeredPlate,
    mixed: &MixedPixels,
    LightCells { side_px, per_layer }: LightCells,
) -> Vec<CellLights> {
    let count = least_light.len();
    let mut cells: BTreeMap<(usize, usize, i32), CellLights> = BTreeMap::new();
    for (pixel, excess) in block.pixels.iter().zip(block.excess.chunks(count)) {
        let index = pixel.0 * input.width + pixel.1;
        let excess = excess.iter().zip(input.planes.iter().zip(least_light));
        let excess: Vec<f32> = excess
            .map(|(light, (plane, least))| {
                if !block.is_partial || plane.samples[index] > *least {
                    *light
                } else {
                    0.0
                }
            })
            .collect();
        if excess.iter().all(|light| *light == 0.0) {
            continue;
        }
        let coordinate = mixed.coordinate_of_light(input, brightest_nearby(input, count, index));
        let depth = (per_layer * coordinate).round() as i32;
        let (row, column) = *pixel;
        let [x, y] = [column + input.origin[0], row + input.origin[1]];
        let lights = cells.entry((y / side_px, x / side_px, depth));
        let lights = lights.or_default();
        lights.side_px = side_px;
        lights.before = input.origin.map(|at| at % side_px);
        lights.add((column, row), coordinate, &excess);
    }
    cells.into_values().collect()
}

/// Returns the pixel that steps to the brightest neighbour lead to, from pixel `index`: [`STEPS_TO_BRIGHTEST`] at most.
fn brightest_nearby(input: &LayeredPlate, count: usize, index: usize) -> usize {
    let light = |at: usize| -> f32 {
        let planes = input.planes[..count].iter();
        planes.map(|plane| plane.samples[at]).sum()
    };
    let mut at = index;
    for _ in 0..STEPS_TO_BRIGHTEST {
        let around = input.neighbourhood(at, 1);
        let brightest = around.fold(at, |best, other| {
            if light(other) > light(best) {
                other
            } else {
                best
            }
        });
        if brightest == at {
            break;
        }
        at = brightest;
    }
    at
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
    /// against the radius of their disc. Without cuts all are one group.
    fn groups(&self, radius_px: f64, planes: usize) -> Vec<Vec<PixelLight<'_>>> {
        let side = if self.is_cut {
            ((radius_px / RADIUS_OF_GROUP).round() as usize).clamp(1, self.side_px)
        } else {
            self.side_px
        };
        let mut groups: BTreeMap<(usize, usize), Vec<PixelLight>> = BTreeMap::new();
        for (&(column, row), light) in self.pixels.iter().zip(self.excess.chunks(planes)) {
            let [x, y] = [column + self.before[0], row + self.before[1]];
            let group = groups.entry((y % self.side_px / side, x % self.side_px / side));
            let group = group.or_default();
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
