//! The plate cut into slices: which layers have light where, and what the inner renderer is given.
//!
//! A pixel between two layers gives each the share that is linear in vergence, so that a tilted surface
//! has no bands.

use super::depth_layers::DepthLayers;
use super::hidden::HiddenRow;
use crate::scatter::kernel_reach;
use crate::{Plane, RenderWindow, Scene};
use rayon::prelude::*;

/// Windows are made of blocks of this side on a grid fixed to the frame, px.
const BLOCK_PX: usize = 32;
/// What is to be cut: the visible samples and those hidden behind them.
pub(super) struct Stock<'a> {
    pub(super) planes: &'a [Plane<'a>],
    /// Place of every pixel on the layers.
    pub(super) places: &'a [f32],
    /// Samples besides, hidden ones and corrections of those at edges.
    pub(super) further: &'a [&'a [HiddenRow]],
    pub(super) width: usize,
}

/// Blocks of the plate, on a grid fixed to the frame.
#[derive(Clone, Copy)]
struct Blocks {
    /// Pixels of the first block that lie before the plate, along x and y.
    before: [usize; 2],
    size: [usize; 2],
    columns: usize,
    rows: usize,
}

impl Blocks {
    fn of(scene: &Scene) -> Self {
        let origin = [scene.map.origin.x_px, scene.map.origin.y_px];
        let before =
            origin.map(|at| (at * scene.map.scale).round().rem_euclid(BLOCK_PX as f64) as usize);
        let size = [scene.width, scene.height];
        Self {
            before,
            size,
            columns: (scene.width + before[0]).div_ceil(BLOCK_PX),
            rows: (scene.height + before[1]).div_ceil(BLOCK_PX),
        }
    }

    /// The block of pixel `at` along `axis`.
    fn holding(&self, axis: usize, at: usize) -> usize {
        (at + self.before[axis]) / BLOCK_PX
    }

    /// The first pixel on the plate of block `block` along `axis`.
    fn first(&self, axis: usize, block: usize) -> usize {
        (block * BLOCK_PX)
            .saturating_sub(self.before[axis])
            .min(self.size[axis])
    }

    /// The part of the plate under a rectangle of blocks.
    fn crop(&self, [left, top, right, bottom]: Box4) -> RenderWindow {
        let (column, row) = (self.first(0, left), self.first(1, top));
        RenderWindow {
            column,
            row,
            width: self.first(0, right) - column,
            height: self.first(1, bottom) - row,
        }
    }
}

/// Columns and rows of blocks, ends not included.
type Box4 = [usize; 4];

fn joined(a: Box4, b: Box4) -> Box4 {
    [
        a[0].min(b[0]),
        a[1].min(b[1]),
        a[2].max(b[2]),
        a[3].max(b[3]),
    ]
}

impl Stock<'_> {
    /// The parts of the plate that the light of each layer reaches; no light of one reaches another.
    pub(super) fn crops(&self, scene: &Scene, layers: &DepthLayers) -> Vec<Vec<RenderWindow>> {
        let blocks = Blocks::of(scene);
        let lit = self.lit(&blocks, layers);
        lit.par_iter()
            .enumerate()
            .map(|(layer, lit)| reached(scene, &blocks, lit, layers.vergence(layer)))
            .collect()
    }

    /// Of each layer, which blocks have light, row-major.
    fn lit(&self, blocks: &Blocks, layers: &DepthLayers) -> Vec<Vec<bool>> {
        let row_of_blocks = |block_row: usize| {
            let mut lit = vec![vec![false; blocks.columns]; layers.len()];
            let mut add = |place: f32, column: usize| {
                let (low, high) = layers.around(place);
                for layer in [low, high] {
                    if share(place, layers.coordinate_of(layer)) > 0.0 {
                        lit[layer][blocks.holding(0, column)] = true;
                    }
                }
            };
            for row in blocks.first(1, block_row)..blocks.first(1, block_row + 1) {
                for (column, place) in self.row(row).iter().enumerate() {
                    add(*place, column);
                }
                for further in self.further {
                    let HiddenRow {
                        columns, places, ..
                    } = &further[row];
                    for (column, place) in columns.iter().zip(places) {
                        add(*place, *column as usize);
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
        &self.places[row * self.width..(row + 1) * self.width]
    }

    /// The planes and the presence of the slice at `place` on the layers, within `crop`.
    pub(super) fn slice(&self, place: f32, crop: RenderWindow) -> (Vec<Vec<f32>>, Vec<f32>) {
        let size = crop.width * crop.height;
        let mut presence = vec![0.0; size];
        let lines = presence.par_chunks_mut(crop.width).enumerate();
        lines.for_each(|(line, out)| {
            let row = &self.row(crop.row + line)[crop.column..];
            for (out, own) in out.iter_mut().zip(row) {
                *out = share(*own, place);
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
        for further in self.further {
            let rows = &further[crop.row..crop.row + crop.height];
            add(rows, place, crop, &mut planes, &mut presence);
        }
        (planes, presence)
    }
}

/// Adds the samples of `rows` that the slice at `place` has to it.
fn add(
    rows: &[HiddenRow],
    place: f32,
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
            .zip(&row.places[range.clone()]);
        for (((column, own), weight), samples) in all.zip(&row.weights[range]).zip(samples) {
            let share = share(*own, place);
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

/// How much of a sample at `own` place belongs to the slice at `place`.
fn share(own: f32, place: f32) -> f32 {
    (1.0 - (own - place).abs()).max(0.0)
}

/// The parts of the plate that light from the blocks `lit`, all at `vergence`, reaches.
fn reached(scene: &Scene, blocks: &Blocks, lit: &[bool], vergence: f64) -> Vec<RenderWindow> {
    let place = |index: usize| (index % blocks.columns, index / blocks.columns);
    let one = |index: usize| {
        let (x, y) = place(index);
        [x, y, x + 1, y + 1]
    };
    let indices = || (0..lit.len()).filter(|index| lit[*index]);
    let Some(all) = indices().map(one).reduce(joined) else {
        return Vec::new();
    };
    let far = kernel_reach(scene, blocks.crop(all), vergence);
    let wider = |start: usize, end: usize, axis: usize, before: f64, after: f64| {
        let first = blocks
            .first(axis, start)
            .saturating_sub(before.ceil() as usize);
        let last = (blocks.first(axis, end) + after.ceil() as usize).min(blocks.size[axis]) - 1;
        (blocks.holding(axis, first), blocks.holding(axis, last) + 1)
    };
    let mut covered = vec![false; lit.len()];
    for [left, top, right, bottom] in indices().map(one) {
        let (left, right) = wider(left, right, 0, far.left_px, far.right_px);
        let (top, bottom) = wider(top, bottom, 1, far.up_px, far.down_px);
        for y in top..bottom {
            covered[y * blocks.columns + left..y * blocks.columns + right].fill(true);
        }
    }
    let boxes = apart(islands(&mut covered, blocks.columns));
    boxes.into_iter().map(|found| blocks.crop(found)).collect()
}

/// Rectangles about the connected parts of `covered`, rows of `columns`, which is used up.
fn islands(covered: &mut [bool], columns: usize) -> Vec<Box4> {
    let mut found = Vec::new();
    let mut open = Vec::new();
    for start in 0..covered.len() {
        if !covered[start] {
            continue;
        }
        let mut about = [usize::MAX, usize::MAX, 0, 0];
        covered[start] = false;
        open.push(start);
        while let Some(index) = open.pop() {
            let (x, y) = (index % columns, index / columns);
            about = joined(about, [x, y, x + 1, y + 1]);
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
        found.push(about);
    }
    found
}

/// The same with rectangles that overlap joined, until none do.
fn apart(mut boxes: Vec<Box4>) -> Vec<Box4> {
    let overlap = |a: &Box4, b: &Box4| a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
    let mut done: Vec<Box4> = Vec::new();
    while let Some(next) = boxes.pop() {
        match done.iter().position(|other| overlap(other, &next)) {
            // The joined one may overlap others by now.
            Some(index) => boxes.push(joined(done.swap_remove(index), next)),
            None => done.push(next),
        }
    }
    done.sort_unstable();
    done
}

/// The scene of a slice: `crop` of the plate, all at one vergence.
pub(super) fn cropped<'a>(scene: &Scene<'a>, crop: RenderWindow, vergence: f64) -> Scene<'a> {
    Scene {
        width: crop.width,
        height: crop.height,
        map: scene.map.moved(crop.column as f64, crop.row as f64),
        vergence: crate::VergencePass::Constant(vergence),
        ..*scene
    }
}
