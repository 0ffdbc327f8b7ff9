//! What a plan and its stencils do to planes of light: down the pyramid, gathered tile by tile and doubled
//! up again. It is linear; `adjoint` turns it round.

use super::corners::{Mixed, Places};
use super::edges::{cut, mirrored};
use super::fir::{Blend, LANES, ROWS};
use super::image::{Image, View};
use super::plan::Level;
use super::pyramid::{Doubling, doubled, halved};
use crate::{Edges, RenderWindow, cancelled};
use rayon::prelude::*;
use seidel_optics::error::Result;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A render, ready for any light.
pub(super) struct Pass {
    /// The work of all levels, finest first.
    pub(super) levels: Vec<Level>,
    /// The stencils of each level.
    pub(super) stencils: Vec<Places<Mixed>>,
    /// The level at which light beyond the plate's edges is folded back.
    pub(super) folded: usize,
    /// Which stencil of a corner each plane has.
    pub(super) mix_of: Vec<usize>,
    /// Columns and rows of the plate.
    pub(super) size: (usize, usize),
    pub(super) edges: Edges,
}

impl Pass {
    /// The `window` of the plate that `planes` become.
    ///
    /// # Errors
    /// If `progress` says to stop.
    pub(super) fn forward(
        &self,
        planes: &[View],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        let images = self.finest(planes, progress)?;
        let plates = images
            .par_iter()
            .map(|image| cut(image, self.size, self.edges_at(0), window));
        Ok(plates.collect())
    }

    /// A plane of the plate.
    pub(super) fn view<'a>(&self, samples: &'a [f32]) -> View<'a> {
        View {
            left: 0,
            top: 0,
            width: self.size.0,
            height: self.size.1,
            samples,
        }
    }

    /// What lies beyond the edges when the images of `level` are cut to the plate.
    pub(super) fn edges_at(&self, level: usize) -> Edges {
        if level == self.folded {
            self.edges
        } else {
            Edges::Black
        }
    }

    /// Columns and rows of the plate on `level`, one on which light is folded or below.
    pub(super) fn size_at(&self, level: usize) -> (usize, usize) {
        (self.size.0 >> level, self.size.1 >> level)
    }

    /// First column and row, and columns and rows, of what is made at a level.
    pub(super) fn place(level: &Level) -> ((i32, i32), (usize, usize)) {
        let (rows, columns) = level.extent();
        let side = level.grid.tile;
        (
            (columns.start * side as i32, rows.start * side as i32),
            (columns.len() * side, rows.len() * side),
        )
    }

    /// All levels, coarsest first; the finest is left. Light beyond the plate's edges is folded back at
    /// level `folded`, unless that is the finest.
    fn finest(
        &self,
        planes: &[View],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Image>> {
        let mut pyramid: Vec<Vec<Image>> = Vec::new();
        for level in 1..self.levels.len() {
            let above = match level {
                1 => planes.iter().map(halved).collect(),
                _ => pyramid[level - 2]
                    .iter()
                    .map(|image| halved(&image.view()))
                    .collect(),
            };
            pyramid.push(above);
        }
        let rows = self.levels.iter().map(|level| level.extent().0.len());
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
            let (rows, columns) = level.extent();
            let (place, size) = Self::place(level);
            let mut images = vec![Image::zeros(place, size); planes.len()];
            let mut bands = Vec::new();
            for (plane, image) in images.iter_mut().enumerate() {
                let band = level.grid.tile * image.width.max(1);
                for (row, band) in rows.clone().zip(image.samples.chunks_exact_mut(band)) {
                    bands.push((plane, row, band));
                }
            }
            bands.into_par_iter().try_for_each_init(
                Space::default,
                |space, (plane, row, band)| {
                    let work = Work {
                        level,
                        stencils,
                        mix: self.mix_of[plane],
                        sources: &views[plane],
                        coarser: &coarser[plane].view(),
                    };
                    work.band(row, columns.clone(), band, space);
                    let share = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / total as f64;
                    if progress(share) {
                        Ok(())
                    } else {
                        Err(cancelled())
                    }
                },
            )?;
            coarser = self.closed(images, level.grid.level as usize);
        }
        Ok(coarser)
    }

    /// The images of a level as the next finer one needs them: whole as they are, or where light has
    /// been folded back, the plate and its mirror.
    fn closed(&self, images: Vec<Image>, level: usize) -> Vec<Image> {
        if level == 0 || level > self.folded {
            return images;
        }
        let (size, edges) = (self.size_at(level), self.edges_at(level));
        let close = |image: &Image| {
            mirrored(
                &cut(image, size, edges, RenderWindow::from_size(size.0, size.1)),
                size,
            )
        };
        images.par_iter().map(close).collect()
    }
}

/// Columns and rows that are gathered for a tile of `side`: whole vectors and blocks.
pub(super) fn gathered_size(side: usize) -> (usize, usize) {
    (side.next_multiple_of(LANES), side.next_multiple_of(ROWS))
}

/// What one plane's tiles at one level are made of.
struct Work<'a> {
    level: &'a Level,
    stencils: &'a Places<Mixed>,
    mix: usize,
    sources: &'a View<'a>,
    coarser: &'a View<'a>,
}

/// Buffers of one thread.
#[derive(Default)]
struct Space {
    blend: Blend,
    window: Vec<f32>,
    tile: Vec<f32>,
    doubling: Doubling,
}

/// Sets `blend` to what the tile at (row, column) of a level is gathered with.
pub(super) fn set_blend(
    (level, stencils, mix): (&Level, &Places<Mixed>, usize),
    (row, column): (i32, i32),
    blend: &mut Blend,
) {
    let corners = [
        (row, column),
        (row, column + 1),
        (row + 1, column),
        (row + 1, column + 1),
    ];
    let Some(stencils) = corners
        .map(|corner| stencils.at(corner).map(|mixed| &mixed[mix]))
        .into_iter()
        .collect::<Option<Vec<_>>>()
    else {
        unreachable!("the corners of all tiles to gather were made");
    };
    let corners = [stencils[0], stencils[1], stencils[2], stencils[3]];
    blend.set(corners, level.grid.tile);
}

impl Work<'_> {
    /// The tiles of `row` into `band`, which holds the tile columns `columns`.
    fn band(&self, row: i32, columns: std::ops::Range<i32>, band: &mut [f32], space: &mut Space) {
        let side = self.level.grid.tile;
        let stride = columns.len() * side;
        for (slot, column) in columns.enumerate() {
            let place = (row, column);
            // Gathered tiles are whole blocks and vectors.
            let mut width = side;
            if self.level.gathered.contains(&place) {
                self.gather(place, space);
                width = gathered_size(side).0;
            } else if self.level.doubled.contains(&place) {
                let corner = (column * side as i32, row * side as i32);
                space.tile.resize(side * side, 0.0);
                doubled(
                    self.coarser,
                    corner,
                    side,
                    &mut space.doubling,
                    &mut space.tile,
                );
            } else {
                continue;
            }
            for (y, line) in space.tile.chunks_exact(width).take(side).enumerate() {
                band[y * stride + slot * side..][..side].copy_from_slice(&line[..side]);
            }
        }
    }

    fn gather(&self, (row, column): (i32, i32), space: &mut Space) {
        let side = self.level.grid.tile;
        let set = (self.level, self.stencils, self.mix);
        set_blend(set, (row, column), &mut space.blend);
        let blend = &mut space.blend;
        let corner = (
            column * side as i32 + blend.columns.start,
            row * side as i32 + blend.rows.start,
        );
        let (width, height) = gathered_size(side);
        let size = (
            width + blend.columns.len().max(1) - 1,
            height + blend.rows.len().max(1) - 1,
        );
        let stride = size.0 + LANES;
        space.tile.resize(width * height, 0.0);
        if blend.len() > 0 && self.sources.copy(corner, size, stride, &mut space.window) {
            blend.gather(&space.window, stride, width, &mut space.tile);
        } else {
            space.tile.fill(0.0);
        }
    }
}
