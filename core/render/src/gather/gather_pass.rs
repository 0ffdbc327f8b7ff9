//! The linear part of a render: planes go down the pyramid, are gathered tile by tile and upsampled again. `adjoint`
//! holds its transpose.

use super::corner_stencils::{MixStencils, SparseGrid};
use super::edges::{add_folded, folded, with_mirrored_margin};
use super::fir::{BilinearFir, LANES, LitSources, ROWS};
use super::image::{Image, Rect, Size, View};
use super::plan::Level;
use super::pyramid::{UpsampleBuffers, downsample, upsample_tile};
use super::tile_grid::GridIndex;
use crate::{Edges, RenderWindow, cancelled};
use rayon::prelude::*;
use seidel_optics::error::Result;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Samples of a plane that are computed at a time on the finest level: those of a plate of 4K, so that smaller plates are one part.
const PART_SAMPLES: usize = 16 << 20;

/// A planned render with its stencils, applicable to any light.
pub(super) struct GatherPass {
    /// The work of all levels, finest first.
    pub(super) levels: Vec<Level>,
    /// Stencils of each level, at the corners of gathered tiles.
    pub(super) stencils: Vec<SparseGrid<MixStencils>>,
    /// Level at which light beyond the plate's edges is folded back.
    pub(super) fold_level: usize,
    /// Index of each plane's stencil at a corner.
    pub(super) mix_of: Vec<usize>,
    /// Size of the plate.
    pub(super) size: Size,
    pub(super) edges: Edges,
}

impl GatherPass {
    /// Blurs `planes` and returns the pixels of `window`.
    ///
    /// # Errors
    /// A cancelled render, if `progress` returned false.
    pub(super) fn forward(
        &self,
        planes: &[View],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        let mut plates = vec![vec![0.0; window.width * window.height]; planes.len()];
        self.compute(planes, progress, &mut |images| {
            let folds = plates.par_iter_mut().zip(images);
            folds.for_each(|(plate, image)| {
                add_folded(image, self.size, self.edges_at(0), window, plate);
            });
        })?;
        Ok(plates)
    }

    /// Returns the boundary condition with which the images of `level` are cut to the plate.
    pub(super) fn edges_at(&self, level: usize) -> Edges {
        if level == self.fold_level {
            self.edges
        } else {
            Edges::Black
        }
    }

    /// Returns the size of the plate on `level`, which is the fold level or finer.
    pub(super) fn size_at(&self, level: usize) -> Size {
        Size {
            width: self.size.width >> level,
            height: self.size.height >> level,
        }
    }

    /// Returns the pixels that a level computes.
    pub(super) fn rect(level: &Level) -> Rect {
        let extent = level.extent();
        let side = level.grid.tile;
        Rect {
            left: extent.columns.start * side as i32,
            top: extent.rows.start * side as i32,
            width: extent.columns.len() * side,
            height: extent.rows.len() * side,
        }
    }

    /// Computes all levels from the coarsest to the finest, and passes the images of the finest on in parts, from the top down: with
    /// light that leaves a mirrored strip they may hold a hundred times its pixels.
    fn compute(
        &self,
        planes: &[View],
        progress: &(dyn Fn(f64) -> bool + Sync),
        take: &mut dyn FnMut(&[Image]),
    ) -> Result<()> {
        let mut pyramid: Vec<Vec<Image>> = Vec::new();
        for level in 1..self.levels.len() {
            let above = match level {
                1 => planes.iter().map(downsample).collect(),
                _ => pyramid[level - 2]
                    .iter()
                    .map(|image| downsample(&image.view()))
                    .collect(),
            };
            pyramid.push(above);
        }
        let rows = self.levels.iter().map(|level| level.extent().rows.len());
        let total = rows.sum::<usize>() * planes.len();
        let done = AtomicUsize::new(0);
        let mut coarser: Vec<Image> = vec![Image::default(); planes.len()];
        for (level, stencils) in self.levels.iter().zip(&self.stencils).rev() {
            let views: Vec<View> = match level.grid.level {
                0 => planes.to_vec(),
                above => pyramid[above as usize - 1]
                    .iter()
                    .map(Image::view)
                    .collect(),
            };
            let extent = level.extent();
            if extent.rows.is_empty() {
                coarser = vec![Image::default(); planes.len()];
            }
            let whole = Self::rect(level);
            let band = level.grid.tile * whole.width.max(1);
            let part = match level.grid.level {
                0 => (PART_SAMPLES / band).max(1),
                _ => extent.rows.len().max(1),
            };
            for first in extent.rows.clone().step_by(part) {
                let rows = first..extent.rows.end.min(first + part as i32);
                let rect = Rect {
                    top: first * level.grid.tile as i32,
                    height: rows.len() * level.grid.tile,
                    ..whole
                };
                let mut images = vec![Image::zeros(rect); planes.len()];
                let mut bands = Vec::new();
                for (plane, image) in images.iter_mut().enumerate() {
                    for (row, band) in rows.clone().zip(image.samples.chunks_exact_mut(band)) {
                        bands.push((plane, row, band));
                    }
                }
                bands.into_par_iter().try_for_each_init(
                    Scratch::default,
                    |scratch, (plane, row, band)| {
                        let job = BandJob {
                            level,
                            stencils,
                            mix: self.mix_of[plane],
                            sources: &views[plane],
                            coarser: &coarser[plane].view(),
                        };
                        job.band(row, extent.columns.clone(), band, scratch);
                        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                        if progress(done as f64 / total as f64) {
                            Ok(())
                        } else {
                            Err(cancelled())
                        }
                    },
                )?;
                if level.grid.level == 0 {
                    take(&images);
                } else {
                    coarser = self.closed(images, level.grid.level as usize);
                }
            }
        }
        Ok(())
    }

    /// Prepares the images of a level for the next finer one: unchanged, or from the fold level down the plate with its
    /// mirrored margin.
    fn closed(&self, images: Vec<Image>, level: usize) -> Vec<Image> {
        if level == 0 || level > self.fold_level {
            return images;
        }
        let (size, edges) = (self.size_at(level), self.edges_at(level));
        let window = RenderWindow::from_size(size.width, size.height);
        let close = |image: &Image| with_mirrored_margin(&folded(image, size, edges, window), size);
        images.par_iter().map(close).collect()
    }
}

/// Returns the size gathered for a tile of `side` pixels, rounded up to whole vectors and blocks of rows.
pub(super) fn gathered_size(side: usize) -> Size {
    Size {
        width: side.next_multiple_of(LANES),
        height: side.next_multiple_of(ROWS),
    }
}

/// The inputs of one plane's tiles at one level.
struct BandJob<'a> {
    level: &'a Level,
    stencils: &'a SparseGrid<MixStencils>,
    mix: usize,
    sources: &'a View<'a>,
    coarser: &'a View<'a>,
}

/// Buffers of one thread.
#[derive(Default)]
struct Scratch {
    fir: BilinearFir,
    window: Vec<f32>,
    tile: Vec<f32>,
    upsampling: UpsampleBuffers,
}

/// Sets `fir` to the stencils of channel mix `mix` at the corners of `tile`.
pub(super) fn set_fir(
    level: &Level,
    stencils: &SparseGrid<MixStencils>,
    mix: usize,
    tile: GridIndex,
    fir: &mut BilinearFir,
) {
    set_corners(level.grid.tile, stencils, mix, tile, fir);
}

/// Sets `fir` to the stencils of channel mix `mix` at the corners of `tile`, of `side` pixels.
pub(super) fn set_corners(
    side: usize,
    stencils: &SparseGrid<MixStencils>,
    mix: usize,
    tile: GridIndex,
    fir: &mut BilinearFir,
) {
    let Some(stencils) = tile
        .corners()
        .map(|corner| stencils.at(corner).map(|mixes| &mixes[mix]))
        .into_iter()
        .collect::<Option<Vec<_>>>()
    else {
        unreachable!("stencils exist at the corners of all tiles with work");
    };
    let corners = [stencils[0], stencils[1], stencils[2], stencils[3]];
    fir.set(corners, side);
}

impl BandJob<'_> {
    /// Computes the tiles of `row` in `columns` into `band`.
    fn band(
        &self,
        row: i32,
        columns: std::ops::Range<i32>,
        band: &mut [f32],
        scratch: &mut Scratch,
    ) {
        let side = self.level.grid.tile;
        let stride = columns.len() * side;
        for (slot, column) in columns.enumerate() {
            let tile = GridIndex::new(row, column);
            // Gathered tiles are rounded up to whole vectors.
            let mut width = side;
            if self.level.gathered.contains(&tile) {
                self.gather(tile, scratch);
                width = gathered_size(side).width;
            } else if self.level.upsampled.contains(&tile) {
                scratch.tile.resize(side * side, 0.0);
                upsample_tile(
                    self.coarser,
                    column * side as i32,
                    row * side as i32,
                    side,
                    &mut scratch.upsampling,
                    &mut scratch.tile,
                );
            } else {
                continue;
            }
            for (y, line) in scratch.tile.chunks_exact(width).take(side).enumerate() {
                band[y * stride + slot * side..][..side].copy_from_slice(&line[..side]);
            }
        }
    }

    /// Gathers `tile` into `scratch.tile`.
    fn gather(&self, tile: GridIndex, scratch: &mut Scratch) {
        let side = self.level.grid.tile;
        let fir = &mut scratch.fir;
        set_fir(self.level, self.stencils, self.mix, tile, fir);
        let Size { width, height } = gathered_size(side);
        let window = Rect {
            left: tile.column * side as i32 + fir.columns.start,
            top: tile.row * side as i32 + fir.rows.start,
            width: width + fir.columns.len().max(1) - 1,
            height: height + fir.rows.len().max(1) - 1,
        };
        let stride = window.width + LANES;
        scratch.tile.resize(width * height, 0.0);
        scratch.window.resize(window.height * stride, 0.0);
        if fir.len() > 0 && self.sources.copy(window, stride, &mut scratch.window) {
            let sources = &scratch.window;
            fir.gather(sources, stride, &LitSources::ALL, width, &mut scratch.tile);
        } else {
            scratch.tile.fill(0.0);
        }
    }
}
