//! The adjoint of a render: light on the blurred plate goes back to the sources that contribute to it.
//!
//! Each step of the forward pass is linear with a simple transpose. The transpose of downsampling is a quarter of
//! upsampling, that of a tile's stencils is another set of stencils, that of folding is unfolding. So
//! <A x, y> = <x, A^T y> to rounding.

use super::edges::{folded, margin_rect, unfolded};
use super::fir::{BilinearFir, LANES, LitSources};
use super::gather_pass::{GatherPass, gathered_size, set_fir};
use super::image::{Image, Rect, View};
use super::plan::Level;
use super::pyramid::{UpsampleBuffers, downsample, upsample_tile};
use super::tile_grid::GridIndex;
use crate::{Edges, RenderWindow};
use rayon::prelude::*;

/// Side of the squares in which light is moved to the next finer level, pixels.
const SQUARE: usize = 64;

impl GatherPass {
    /// Applies the adjoint of [`GatherPass::forward`] for the whole plate to the plane `index`.
    pub(super) fn adjoint(&self, plate: &[f32], index: usize) -> Vec<f32> {
        let mix = self.mix_of[index];
        let mut sources = self.empty_sources();
        let Some(first) = self.levels.first() else {
            return sources.swap_remove(0).samples;
        };
        let mut light = unfolded(plate, self.size, self.edges_at(0), Self::rect(first));
        for (index, level) in self.levels.iter().enumerate() {
            self.gather_adjoint(index, mix, &light, &mut sources[index]);
            let Some(above) = self.levels.get(index + 1) else {
                break;
            };
            let upsampled = upsampled_part(level, &light);
            let mut coarse = downsample(&upsampled.view());
            coarse.samples.iter_mut().for_each(|v| *v *= 4.0);
            light = self.unclosed(&coarse, index + 1, Self::rect(above));
        }
        for index in (1..sources.len()).rev() {
            let (finer, coarser) = sources.split_at_mut(index);
            if let (Some(finer), Some(coarser)) = (finer.last_mut(), coarser.first()) {
                add_downsampling_adjoint(finer, &coarser.view());
            }
        }
        sources.swap_remove(0).samples
    }

    /// Returns black images for the sources on each level.
    fn empty_sources(&self) -> Vec<Image> {
        let mut sources = vec![Image::zeros(Rect {
            left: 0,
            top: 0,
            width: self.size.width,
            height: self.size.height,
        })];
        for level in 1..self.levels.len() {
            sources.push(downsample(&sources[level - 1].view()));
        }
        sources
    }

    /// The transpose of closing the images of `level`, which covers `rect`.
    fn unclosed(&self, light: &Image, level: usize, rect: Rect) -> Image {
        if level > self.fold_level {
            return light.cropped(rect);
        }
        let size = self.size_at(level);
        let window = RenderWindow::from_size(size.width, size.height);
        let closed = light.cropped(margin_rect(size));
        let plate = folded(&closed, size, Edges::Mirror, window);
        unfolded(&plate, size, self.edges_at(level), rect)
    }

    /// Adds the transpose of gathering at level `index` to its `sources`.
    fn gather_adjoint(&self, index: usize, mix: usize, light: &Image, sources: &mut Image) {
        let (level, stencils) = (&self.levels[index], &self.stencils[index]);
        let tiles: Vec<GridIndex> = level.gathered.iter().copied().collect();
        let spread = tiles.par_iter().map_init(
            || (BilinearFir::default(), Vec::new()),
            |(fir, window), tile| {
                set_fir(level, stencils, mix, *tile, fir);
                tile_adjoint(fir, level.grid.tile, *tile, light, window)
            },
        );
        sources.add_all(&spread.flatten().collect::<Vec<_>>());
    }
}

/// Returns the transpose of gathering `tile`, of `side` pixels, from `light`; `None` where it is dark.
fn tile_adjoint(
    fir: &BilinearFir,
    side: usize,
    tile: GridIndex,
    light: &Image,
    window: &mut Vec<f32>,
) -> Option<Image> {
    if fir.len() == 0 {
        return None;
    }
    let mut transposed = fir.transposed();
    let (columns, rows) = (fir.columns.len() - 1, fir.rows.len() - 1);
    let width = gathered_size(side + columns).width;
    let height = gathered_size(side + rows).height;
    let stride = width + columns + LANES;
    window.clear();
    window.resize(stride * (height + rows), 0.0);
    let (left, top) = (tile.column * side as i32, tile.row * side as i32);
    let tile = light.cropped(Rect {
        left,
        top,
        width: side,
        height: side,
    });
    if tile.samples.iter().all(|v| *v == 0.0) {
        return None;
    }
    for (y, line) in tile.samples.chunks_exact(side).enumerate() {
        window[(rows + y) * stride + columns..][..side].copy_from_slice(line);
    }
    let mut out = vec![0.0; width * height];
    let lit = LitSources {
        columns: columns..columns + side,
        rows: rows..rows + side,
    };
    transposed.gather(window, stride, &lit, width, &mut out);
    let mut spread = Image::zeros(Rect {
        left: left + fir.columns.start,
        top: top + fir.rows.start,
        width: side + columns,
        height: side + rows,
    });
    for (line, out) in spread
        .samples
        .chunks_exact_mut(side + columns)
        .zip(out.chunks_exact(width))
    {
        line.copy_from_slice(&out[..side + columns]);
    }
    Some(spread)
}

/// Returns the part of `light` in tiles that are upsampled.
fn upsampled_part(level: &Level, light: &Image) -> Image {
    let mut part = Image::zeros(light.rect());
    let side = level.grid.tile;
    for &GridIndex { row, column } in &level.upsampled {
        part.add(&light.cropped(Rect {
            left: column * side as i32,
            top: row * side as i32,
            width: side,
            height: side,
        }));
    }
    part
}

/// Adds the transpose of downsampling, applied to the next coarser level, to `finer`.
fn add_downsampling_adjoint(finer: &mut Image, coarser: &View) {
    // Upsampled tiles begin at even pixels.
    let first = (finer.left.div_euclid(2) * 2, finer.top.div_euclid(2) * 2);
    let end = (
        finer.left + finer.width as i32,
        finer.top + finer.height as i32,
    );
    let rows: Vec<i32> = (first.1..end.1).step_by(SQUARE).collect();
    let corners: Vec<(i32, i32)> = rows
        .iter()
        .flat_map(|top| (first.0..end.0).step_by(SQUARE).map(|left| (left, *top)))
        .collect();
    let squares = corners
        .par_iter()
        .map_init(UpsampleBuffers::default, |buffers, corner| {
            let mut square = Image::zeros(Rect {
                left: corner.0,
                top: corner.1,
                width: SQUARE,
                height: SQUARE,
            });
            let (left, top) = *corner;
            upsample_tile(coarser, left, top, SQUARE, buffers, &mut square.samples);
            square.samples.iter_mut().for_each(|v| *v *= 0.25);
            square
        });
    finer.add_all(&squares.collect::<Vec<_>>());
}
