//! The samples of each depth layer, and the crops of the plate that its blurred light reaches.
//!
//! A pixel between two layers belongs to both, with weights linear in vergence, so that slanted surfaces show no bands.

use super::depth_layers::DepthLayers;
use super::extra_samples::ExtraSamples;
use crate::scatter::kernel_reach;
use crate::{Plane, RenderWindow, Scene};
use rayon::prelude::*;
use seidel_optics::psf::KernelBounds;
use std::collections::BTreeMap;

/// Side of the blocks that crops consist of, on a grid fixed to the frame, px.
const BLOCK_PX: usize = 32;

/// Side of the cells whose light has one reach, blocks.
const CELL_BLOCKS: usize = 8;

/// The samples to cut into layers: the visible ones and those in addition.
pub(super) struct LayerSource<'a> {
    pub(super) planes: &'a [Plane<'a>],
    /// Layer coordinate of every pixel.
    pub(super) coordinates: &'a [f32],
    /// Hidden samples and corrections of mixed pixels, each row by row.
    pub(super) extra: &'a [&'a [ExtraSamples]],
    pub(super) width: usize,
}

/// The blocks of a plate, on a grid fixed to the frame.
#[derive(Clone, Copy)]
struct Blocks {
    /// Pixels of the first block that lie outside the plate, along x and y.
    before: [usize; 2],
    size: [usize; 2],
    columns: usize,
    rows: usize,
}

impl Blocks {
    fn new(scene: &Scene) -> Self {
        let before = scene.place_in_cell(BLOCK_PX);
        let size = [scene.width, scene.height];
        Self {
            before,
            size,
            columns: (scene.width + before[0]).div_ceil(BLOCK_PX),
            rows: (scene.height + before[1]).div_ceil(BLOCK_PX),
        }
    }

    /// Returns the block of pixel `at` along `axis`.
    fn holding(&self, axis: usize, at: usize) -> usize {
        (at + self.before[axis]) / BLOCK_PX
    }

    /// Returns the first pixel of `block` on the plate along `axis`.
    fn first(&self, axis: usize, block: usize) -> usize {
        (block * BLOCK_PX)
            .saturating_sub(self.before[axis])
            .min(self.size[axis])
    }

    /// Returns the blocks whose light gets to `window`.
    ///
    /// Their borders are as far from the window as light gets to either side: what crosses a border is mirrored there, and comes back
    /// by no more than that. One more block is for what coarse levels of the image add to the reach.
    fn needed(&self, window: RenderWindow, reach: &KernelBounds) -> BlockRect {
        let along = |axis: usize, first: usize, length: usize, before: f64, after: f64| {
            let reach = before.max(after).ceil() as usize + BLOCK_PX;
            let last = (first + length - 1 + reach).min(self.size[axis] - 1);
            let first = first.saturating_sub(reach);
            (self.holding(axis, first), self.holding(axis, last) + 1)
        };
        let (left, right) = along(
            0,
            window.column,
            window.width,
            reach.left_px,
            reach.right_px,
        );
        let (top, bottom) = along(1, window.row, window.height, reach.up_px, reach.down_px);
        BlockRect {
            left,
            top,
            right,
            bottom,
        }
    }

    /// Returns the part of the plate under a rectangle of blocks.
    fn crop(&self, blocks: BlockRect) -> RenderWindow {
        let (column, row) = (self.first(0, blocks.left), self.first(1, blocks.top));
        RenderWindow {
            column,
            row,
            width: self.first(0, blocks.right) - column,
            height: self.first(1, blocks.bottom) - row,
        }
    }
}

/// A rectangle of blocks; right and bottom are excluded. The order of fields is that of sorting.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct BlockRect {
    left: usize,
    top: usize,
    right: usize,
    bottom: usize,
}

impl BlockRect {
    fn one(x: usize, y: usize) -> Self {
        Self {
            left: x,
            top: y,
            right: x + 1,
            bottom: y + 1,
        }
    }

    /// Returns the bounding rectangle of both.
    fn union(self, other: Self) -> Self {
        Self {
            left: self.left.min(other.left),
            top: self.top.min(other.top),
            right: self.right.max(other.right),
            bottom: self.bottom.max(other.bottom),
        }
    }

    /// Returns the rectangle that both have; `None` without any.
    fn overlap(self, other: Self) -> Option<Self> {
        self.overlaps(&other).then(|| Self {
            left: self.left.max(other.left),
            top: self.top.max(other.top),
            right: self.right.min(other.right),
            bottom: self.bottom.min(other.bottom),
        })
    }

    fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }
}

/// Returns the crops of the plate that the light of each layer reaches, without what is too far from `window` for its light to get
/// there; `lit` holds the blocks with samples. Crops of a layer do not overlap, and no light of one reaches another.
pub(super) fn crops(
    scene: &Scene,
    lit: &[Vec<bool>],
    layers: &DepthLayers,
    window: RenderWindow,
) -> Vec<Vec<RenderWindow>> {
    let blocks = Blocks::new(scene);
    lit.par_iter()
        .enumerate()
        .map(|(layer, lit)| reached_crops(scene, &blocks, lit, layers.vergence(layer), window))
        .collect()
}

impl LayerSource<'_> {
    /// Returns for each layer which blocks hold samples, row-major.
    pub(super) fn lit(&self, scene: &Scene, layers: &DepthLayers) -> Vec<Vec<bool>> {
        let blocks = &Blocks::new(scene);
        let row_of_blocks = |block_row: usize| {
            let mut lit = vec![vec![false; blocks.columns]; layers.len()];
            let mut add = |coordinate: f32, column: usize| {
                let (low, high) = layers.around(coordinate);
                for layer in [low, high] {
                    if share(coordinate, layers.coordinate_of(layer)) > 0.0 {
                        lit[layer][blocks.holding(0, column)] = true;
                    }
                }
            };
            for row in blocks.first(1, block_row)..blocks.first(1, block_row + 1) {
                for (column, coordinate) in self.row(row).iter().enumerate() {
                    add(*coordinate, column);
                }
                for extra in self.extra {
                    let ExtraSamples {
                        columns,
                        coordinates,
                        ..
                    } = &extra[row];
                    for (column, coordinate) in columns.iter().zip(coordinates) {
                        add(*coordinate, *column as usize);
                    }
                }
            }
            lit
        };
        let rows: Vec<_> = (0..blocks.rows)
            .into_par_iter()
            .map(row_of_blocks)
            .collect();
        let of_layer = |layer: usize| {
            rows.iter()
                .flat_map(|row| row[layer].iter().copied())
                .collect()
        };
        (0..layers.len()).map(of_layer).collect()
    }

    fn row(&self, row: usize) -> &[f32] {
        &self.coordinates[row * self.width..(row + 1) * self.width]
    }

    /// Returns the samples within `crop` of the layer at `coordinate`.
    pub(super) fn layer(&self, coordinate: f32, crop: RenderWindow) -> LayerSamples {
        let size = crop.width * crop.height;
        let mut presence = vec![0.0; size];
        let lines = presence.par_chunks_mut(crop.width).enumerate();
        lines.for_each(|(line, out)| {
            let row = &self.row(crop.row + line)[crop.column..];
            for (out, own) in out.iter_mut().zip(row) {
                *out = share(*own, coordinate);
            }
        });
        let mut planes: Vec<_> = (0..self.planes.len()).map(|_| vec![0.0; size]).collect();
        for (plane, out) in self.planes.iter().zip(&mut planes) {
            let lines = out.par_chunks_mut(crop.width).enumerate();
            lines.for_each(|(line, out)| {
                let from = (crop.row + line) * self.width + crop.column;
                let shares = &presence[line * crop.width..];
                for ((out, sample), share) in out.iter_mut().zip(&plane.samples[from..]).zip(shares)
                {
                    *out = sample * share;
                }
            });
        }
        for extra in self.extra {
            let rows = &extra[crop.row..crop.row + crop.height];
            add_extra(rows, coordinate, crop, &mut planes, &mut presence);
        }
        LayerSamples { planes, presence }
    }
}

/// The samples of a crop of a layer.
pub(super) struct LayerSamples {
    /// Planes, multiplied by presence.
    pub(super) planes: Vec<Vec<f32>>,
    /// Share of each pixel that belongs to the layer.
    pub(super) presence: Vec<f32>,
}

/// Adds the extra samples of `rows` to the layer at `coordinate`.
fn add_extra(
    rows: &[ExtraSamples],
    coordinate: f32,
    crop: RenderWindow,
    planes: &mut [Vec<f32>],
    presence: &mut [f32],
) {
    for (line, row) in rows.iter().enumerate() {
        // Columns ascend.
        let first = |column: usize| row.columns.partition_point(|c| (*c as usize) < column);
        let range = first(crop.column)..first(crop.column + crop.width);
        let samples = row.samples[range.start * planes.len()..].chunks_exact(planes.len());
        let all = row.columns[range.clone()]
            .iter()
            .zip(&row.coordinates[range.clone()]);
        for (((column, own), weight), samples) in all.zip(&row.weights[range]).zip(samples) {
            let share = share(*own, coordinate);
            if share > 0.0 {
                let index = line * crop.width + *column as usize - crop.column;
                presence[index] += share * weight;
                for (plane, sample) in planes.iter_mut().zip(samples) {
                    plane[index] += share * sample;
                }
            }
        }
    }
}

/// Returns the share of a sample at coordinate `own` that belongs to the layer at `coordinate`.
pub(super) fn share(own: f32, coordinate: f32) -> f32 {
    (1.0 - (own - coordinate).abs()).max(0.0)
}

/// Returns the crops of the plate that light from the blocks `lit`, all at `vergence`, reaches, as far as `window` needs them.
fn reached_crops(
    scene: &Scene,
    blocks: &Blocks,
    lit: &[bool],
    vergence: f64,
    window: RenderWindow,
) -> Vec<RenderWindow> {
    let one = |index: usize| BlockRect::one(index % blocks.columns, index / blocks.columns);
    // Blur grows over the field: each cell has a reach of its own.
    let cell_of = |block: BlockRect| (block.top / CELL_BLOCKS, block.left / CELL_BLOCKS);
    let mut cells: BTreeMap<(usize, usize), BlockRect> = BTreeMap::new();
    for block in (0..lit.len()).filter(|index| lit[*index]).map(one) {
        let cell = cells.entry(cell_of(block)).or_insert(block);
        *cell = cell.union(block);
    }
    let reach_of = |(cell, lit): (_, BlockRect)| {
        let reach = kernel_reach(scene, blocks.crop(lit), vergence);
        (cell, reach)
    };
    let reaches: BTreeMap<_, KernelBounds> = cells.into_iter().map(reach_of).collect();
    let Some(farthest) = reaches.values().copied().reduce(larger) else {
        return Vec::new();
    };
    let wider = |start: usize, end: usize, axis: usize, before: f64, after: f64| {
        let first = blocks
            .first(axis, start)
            .saturating_sub(before.ceil() as usize);
        let last = (blocks.first(axis, end) + after.ceil() as usize).min(blocks.size[axis]) - 1;
        (blocks.holding(axis, first), blocks.holding(axis, last) + 1)
    };
    let mut covered = vec![false; lit.len()];
    for block in (0..lit.len()).filter(|index| lit[*index]).map(one) {
        let reach = &reaches[&cell_of(block)];
        let (left, right) = wider(block.left, block.right, 0, reach.left_px, reach.right_px);
        let (top, bottom) = wider(block.top, block.bottom, 1, reach.up_px, reach.down_px);
        for y in top..bottom {
            covered[y * blocks.columns + left..y * blocks.columns + right].fill(true);
        }
    }
    let needed = blocks.needed(window, &farthest);
    let rects = disjoint(islands(&mut covered, blocks.columns));
    rects
        .into_iter()
        .filter_map(|rect| rect.overlap(needed))
        .map(|rect| blocks.crop(rect))
        .collect()
}

/// Returns the larger reach to each side.
fn larger(a: KernelBounds, b: KernelBounds) -> KernelBounds {
    KernelBounds {
        left_px: a.left_px.max(b.left_px),
        right_px: a.right_px.max(b.right_px),
        up_px: a.up_px.max(b.up_px),
        down_px: a.down_px.max(b.down_px),
    }
}

/// Returns the bounding rectangles of the connected components of `covered`, rows of `columns`; clears `covered`.
fn islands(covered: &mut [bool], columns: usize) -> Vec<BlockRect> {
    let mut found = Vec::new();
    let mut open = Vec::new();
    for start in 0..covered.len() {
        if !covered[start] {
            continue;
        }
        let mut bounds = BlockRect::one(start % columns, start / columns);
        covered[start] = false;
        open.push(start);
        while let Some(index) = open.pop() {
            let (x, y) = (index % columns, index / columns);
            bounds = bounds.union(BlockRect::one(x, y));
            let beside = [
                (x > 0).then(|| index - 1),
                (x + 1 < columns).then_some(index + 1),
                index.checked_sub(columns),
                Some(index + columns).filter(|below| *below < covered.len()),
            ];
            for next in beside.into_iter().flatten() {
                if covered[next] {
                    covered[next] = false;
                    open.push(next);
                }
            }
        }
        found.push(bounds);
    }
    found
}

/// Merges overlapping rectangles until none overlap; returns them sorted.
fn disjoint(mut rects: Vec<BlockRect>) -> Vec<BlockRect> {
    let mut done: Vec<BlockRect> = Vec::new();
    while let Some(next) = rects.pop() {
        match done.iter().position(|other| other.overlaps(&next)) {
            // The union may overlap others.
            Some(index) => rects.push(done.swap_remove(index).union(next)),
            None => done.push(next),
        }
    }
    done.sort_unstable();
    done
}

/// Returns the scene of a layer: `crop` of the plate, all at one vergence.
pub(super) fn cropped_scene<'a>(scene: &Scene<'a>, crop: RenderWindow, vergence: f64) -> Scene<'a> {
    Scene {
        width: crop.width,
        height: crop.height,
        map: scene.map.moved(crop.column as f64, crop.row as f64),
        vergence: crate::VergencePass::Constant(vergence),
        ..*scene
    }
}
